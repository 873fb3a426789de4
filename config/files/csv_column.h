// The title of a column: its name and its unit.
#pragma once

#include <string>
#include <string_view>

namespace hystcan::config {

struct CsvColumn {
  std::string title{};  ///< as in the file, without quotes
  std::string name{};   ///< without the unit
  std::string unit{};   ///< the symbol if the unit is known, else as in the file; empty if none
};

/// Splits a title into the name and the unit. The unit is after the name, in parentheses or brackets; a known
/// unit may also be after another mark.
CsvColumn csv_column(std::string_view title);

/// Trims the text and removes enclosing double or single quotes.
std::string without_quotes(std::string_view text);
/// Returns the symbol of a known unit, else the text.
std::string symbol_of(std::string_view unit);

}  // namespace hystcan::config
