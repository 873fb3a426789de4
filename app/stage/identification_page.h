// The page of an identification's report: HTML that needs only the plots beside it.
#pragma once

#include <filesystem>
#include <string>

#include "app/stage/identification_report.h"

namespace hystcan::app {

/// `directory` holds the plots. The page names those that are missing.
std::string page_of(const std::filesystem::path& directory, const IdentificationReport& report);

}  // namespace hystcan::app
