// The texts of a DBC: encoding, escapes, numbers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace hystcan::can::dbc {

/// Converts a text to UTF-8. Returns a UTF-8 text unchanged; reads any other text as Windows-1252, which
/// contains Latin-1.
std::string to_utf8(std::string_view text);

/// Returns the text in UTF-8 with each \" replaced by '"'.
std::string unescaped(std::string_view text);

/// Parses a decimal or hexadecimal integer; 5.0 and 1e3 are allowed. Returns nullopt if the text is not an
/// integer within the range of the return type.
std::optional<std::uint64_t> to_natural(std::string_view text);
std::optional<std::int64_t> to_integer(std::string_view text);

/// Parses a real number. Returns NaN for 1.#IND and similar texts, infinity if the number is too large for a
/// double, and nullopt if the text is not a number.
std::optional<double> to_real(std::string_view text);

}  // namespace hystcan::can::dbc
