// TOML as text. The TOML library (toml++) calls itself once for each part of a dotted key and for each
// bracket, so that a hostile text exhausts its stack. It also misreads characters outside ASCII where TOML
// allows none. Such a text never reaches the library.
#pragma once

#include <toml++/toml.h>
#include <cstddef>
#include <string>
#include <string_view>

namespace hystcan::config {

/// The greatest numbers of open brackets and of parts of one dotted key.
inline constexpr std::size_t deepest_nesting = 16;
inline constexpr std::size_t most_key_parts = 16;

/// Throws Error `NAME:LINE:COLUMN: what, expected TOML` if the library must not see this text.
void refuse_hostile_toml(std::string_view text, const std::string& name);

/// The text as a string of TOML, in quotes: a reader gets the same text back.
std::string toml_string(std::string_view text);

/// Each line of the text, which is UTF-8 and ends with a line end, as a comment. It has a space for each
/// control character.
std::string toml_comment(std::string_view lines);

/// What read_regular_file() expects.
inline constexpr const char* a_toml_file = "a TOML file";

/// Throws Error `NAME:LINE:COLUMN: what, expected TOML`. The sources of the nodes have `origin` as their
/// path; no path if it is empty.
toml::table parse_toml(std::string_view text, const std::string& name, std::string_view origin = {});

}  // namespace hystcan::config
