// A log of candump as input.
#pragma once

#include <filesystem>
#include <fstream>

namespace hystcan::app {

/// Throws config::Error where it can't be read.
std::ifstream open_can_log(const std::filesystem::path& path);

}  // namespace hystcan::app
