// Splits the title of a CSV column, for example "drive [V]", into the name and the unit.
#pragma once

#include <string>
#include <string_view>

namespace hystcan::config {

struct CsvColumn {
  std::string title{};  ///< title as in the file, without quotes: "drive [V]"
  std::string name{};   ///< title without the unit: "drive"
  std::string unit{};   ///< symbol of a known unit, or an unknown unit as in the file; empty: no unit
};

/// Splits a title into the name and the unit. The unit follows the name in parentheses or brackets: "drive
/// (V)". A known unit may also follow a mark such as "_", "/", "," or " in ": "drive_V".
CsvColumn csv_column(std::string_view title);

/// Returns the text without enclosing double or single quotes, and without blanks at both ends.
std::string without_quotes(std::string_view text);
/// Returns the symbol of a known unit, for example "ms" for "msec". Returns an unknown unit unchanged.
std::string symbol_of(std::string_view unit);

}  // namespace hystcan::config
