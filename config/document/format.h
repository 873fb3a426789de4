// The format of our TOML files: configurations, model files, memory files.
//
//   format = 1
//
// stands before the first table. A file without it is older than the numbers and counts as format 0. A file
// of an older format is read as it is, unless it has a key that has gone; that is an error which names what
// is in its place. A newer format than the program knows is an error.
#pragma once

#include <toml++/toml.h>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::config {

inline constexpr int newest_format = 1;
/// Where a file is written.
inline constexpr std::string_view format_line = "format = 1\n";

/// The format that a file with these tables states. Throws Error with its place in the file `name` if it is
/// newer, or no number of a format.
int format_of(const toml::table& root, const std::string& name);

/// A key or a table that files of older formats may have.
struct FormerKey {
  std::string path;      ///< "axis[1].control.adaptation"
  std::string_view now;  ///< "no longer exists: ..."
};
/// Those that these tables have.
std::vector<FormerKey> former_keys(const toml::table& root);

struct Migration {
  int from = newest_format;
  std::string text;
};
/// The text in the newest format: what has gone is commented out. Comments, order and line ends stay. Throws
/// Error, beginning with `name`, if the text is no TOML or of a newer format.
Migration migrate(const std::string& text, const std::string& name);

}  // namespace hystcan::config
