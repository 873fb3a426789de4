// The format of our TOML files: configurations, model files, memory files.
//
//   format = 1
//
// The line must be before the first table; a file without it has format 1. A format newer than newest_format
// is an error.
#pragma once

#include <toml++/toml.h>
#include <string>
#include <string_view>

namespace hystcan::config {

inline constexpr int newest_format = 1;
/// The line at the top of each written file.
inline constexpr std::string_view format_line = "format = 1\n";

/// Throws Error with the place in file `name` if the format is newer than newest_format or not a valid
/// number.
void require_known_format(const toml::table& root, const std::string& name);

}  // namespace hystcan::config
