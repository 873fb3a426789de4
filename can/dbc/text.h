// The texts of a DBC: encoding, escapes, numbers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace hystcan::can::dbc {

/// Returns UTF-8 unchanged. Any other text is read as Windows-1252, which contains Latin-1.
std::string to_utf8(std::string_view text);

/// Returns the text in UTF-8 with each \" replaced by '"'.
std::string unescaped(std::string_view text);

/// Parses a decimal or hexadecimal number; 5.0 and 1e3 are allowed. nullopt if it is not an integer in the
/// range of the type.
std::optional<std::uint64_t> to_natural(std::string_view text);
std::optional<std::int64_t> to_integer(std::string_view text);

/// Returns NaN for 1.#IND and similar texts; infinity if the number is too large for a double.
std::optional<double> to_real(std::string_view text);

}  // namespace hystcan::can::dbc
