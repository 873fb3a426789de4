// The page of an identification's report: HTML that needs nothing but the pictures beside it.
#pragma once

#include <filesystem>
#include <string>

#include "app/report/identification_report.h"

namespace hystcan::app {

/// `directory`: where the pictures are; those that are missing are said to be.
std::string page_of(const std::filesystem::path& directory, const IdentificationReport& report,
                    const WrittenReport& written);

}  // namespace hystcan::app
