// TOML as text. The TOML library (toml++) recurses for each part of a dotted key and for each bracket, so
// that a hostile text exhausts its stack. It also misreads non-ASCII characters outside strings. Such texts
// are refused before the library parses them.
#pragma once

#include <toml++/toml.h>
#include <cstddef>
#include <string>
#include <string_view>

namespace hystcan::config {

/// Maximum numbers of open brackets and of parts of a dotted key.
inline constexpr std::size_t deepest_nesting = 16;
inline constexpr std::size_t most_key_parts = 16;

/// Throws Error `NAME:LINE:COLUMN: PROBLEM, expected TOML` if the library must not parse this text.
void refuse_hostile_toml(std::string_view text, const std::string& name);

/// Returns the text as a quoted TOML string, from which a parser restores the same text.
std::string toml_string(std::string_view text);

/// Returns each line of the text as a comment. The text must be UTF-8 and end with a line end. Each control
/// character becomes a space.
std::string toml_comment(std::string_view lines);

/// The expected content in the errors of read_regular_file().
inline constexpr const char* a_toml_file = "a TOML file";

/// Throws Error `NAME:LINE:COLUMN: PROBLEM, expected TOML`. The source path of the nodes is `origin`, or
/// missing if `origin` is empty.
toml::table parse_toml(std::string_view text, const std::string& name, std::string_view origin = {});

}  // namespace hystcan::config
