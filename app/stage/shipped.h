// The configurations that come with the program.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hystcan::app {

/// Where it is installed, or in the source tree.
std::filesystem::path shipped_file(const std::string& name);

/// Names of the configurations, without .toml, in alphabetical order.
std::vector<std::string> shipped_configurations();

}  // namespace hystcan::app
