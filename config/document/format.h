// The format of our TOML files: configurations, model files, memory files.
//
//   format = 1
//
// stands before the first table; it is also the format of a file that does not state one. A newer format than
// the program knows is an error.
#pragma once

#include <toml++/toml.h>
#include <string>
#include <string_view>

namespace hystcan::config {

inline constexpr int newest_format = 1;
/// Where a file is written.
inline constexpr std::string_view format_line = "format = 1\n";

/// Throws Error with its place in the file `name` if these tables state a newer format, or no number of one.
void require_known_format(const toml::table& root, const std::string& name);

}  // namespace hystcan::config
