// Texts of a DBC: their encoding, their escapes, their numbers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace hystcan::can::dbc {

/// UTF-8 as it is; anything else is taken for Windows-1252, of which Latin-1 is a part.
std::string to_utf8(std::string_view text);

/// A text in quotes: \" is '"'; in UTF-8.
std::string unescaped(std::string_view text);

/// Decimal or hexadecimal, also written as 5.0 or 1e3. Empty where it is no integer of the type's range.
std::optional<std::uint64_t> to_natural(std::string_view text);
std::optional<std::int64_t> to_integer(std::string_view text);

/// NaN for 1.#IND and the like; infinite where a double can't hold it.
std::optional<double> to_real(std::string_view text);

}  // namespace hystcan::can::dbc
