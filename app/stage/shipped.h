// Finds the example configurations that are shipped with the program.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hystcan::app {

/// Returns the path of a shipped file in the installation, or in the source tree if the program is not
/// installed.
std::filesystem::path shipped_file(const std::string& name);

/// Returns the names of the shipped configurations, without .toml, in alphabetical order.
std::vector<std::string> shipped_configurations();

}  // namespace hystcan::app
