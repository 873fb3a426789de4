// Checks and parses TOML text. The TOML library (toml++) recurses for each part of a dotted key and for each
// bracket, so a hostile text could exhaust the stack. The library also misreads non-ASCII characters outside
// strings. Texts with such contents are refused before the library parses them.
#pragma once

#include <toml++/toml.h>
#include <cstddef>
#include <string>
#include <string_view>

namespace hystcan::config {

/// The maximum number of open brackets, and the maximum number of parts of a dotted key such as a.b.c.
inline constexpr std::size_t deepest_nesting = 16;
inline constexpr std::size_t most_key_parts = 16;

/// Throws Error `NAME:LINE:COLUMN: PROBLEM, expected TOML` if the TOML library can't parse `text` safely.
void refuse_hostile_toml(std::string_view text, const std::string& name);

/// Returns `text` as a quoted TOML string. A parser reads the same text back.
std::string toml_string(std::string_view text);

/// Returns the text with `# ` before each line. The text must be UTF-8 and end with a line end. Each control
/// character becomes a space.
std::string toml_comment(std::string_view lines);

/// read_regular_file() names this as the expected content in its error messages.
inline constexpr const char* a_toml_file = "a TOML file";

/// Parses TOML text. Throws Error `NAME:LINE:COLUMN: PROBLEM, expected TOML` if the text is invalid. `origin`
/// becomes the source path of the returned nodes (toml::source_region::path).
toml::table parse_toml(std::string_view text, const std::string& name, std::string_view origin = {});

}  // namespace hystcan::config
