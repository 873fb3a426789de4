// TOML as text. The TOML library (toml++) calls itself once for each part of a dotted key and for each
// bracket, so that a hostile text exhausts its stack. It also misreads characters outside ASCII where TOML
// allows none. Such a text never reaches the library.
#pragma once

#include <toml++/toml.h>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace hystcan::config {

/// The greatest numbers of open brackets and of parts of one dotted key.
inline constexpr std::size_t deepest_nesting = 16;
inline constexpr std::size_t most_key_parts = 16;

/// A place of a text, counted from 1, and what is wrong there.
struct TextRefusal {
  std::size_t line = 1;
  std::size_t column = 1;
  std::string what;
};

/// Why the library must not see this text; empty if it may.
std::optional<TextRefusal> find_refusal(std::string_view text);

/// The text as a string of TOML, in quotes: a reader gets the same text back.
std::string toml_string(std::string_view text);

/// Throws Error `NAME:LINE:COLUMN: what, expected TOML`. The sources of the nodes have `origin` as their
/// path; no path if it is empty.
toml::table parse_toml(std::string_view text, const std::string& name, std::string_view origin = {});

}  // namespace hystcan::config
