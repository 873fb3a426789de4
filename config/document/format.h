// The version of hystcan's TOML file format. Configurations, model files and memory files have this line:
//
//   format = 1
//
// The line must be before the first table. A file without the line has format 1. A file with a format newer
// than newest_format is refused.
#pragma once

#include <toml++/toml.h>
#include <string>
#include <string_view>

namespace hystcan::config {

inline constexpr int newest_format = 1;
/// The first line of each TOML file that hystcan writes: the version of the file format.
inline constexpr std::string_view format_line = "format = 1\n";

/// Throws Error if the key `format` in `root` is newer than newest_format or is not a positive whole number.
/// `name` is the file's name in the message.
void require_known_format(const toml::table& root, const std::string& name);

}  // namespace hystcan::config
