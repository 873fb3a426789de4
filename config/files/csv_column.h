// The title of a column: its name and its unit.
#pragma once

#include <string>
#include <string_view>

namespace hystcan::config {

struct CsvColumn {
  std::string title{};  ///< as in the file, without quotes
  std::string name{};   ///< without the unit
  std::string unit{};   ///< the symbol if it is known, else as in the file; empty: none
};

/// A name and the unit in parentheses or brackets behind it, or behind another mark if it is a
/// known one.
CsvColumn csv_column(std::string_view title);

/// Trimmed, without double or single quotes around it.
std::string without_quotes(std::string_view text);
/// The symbol of a unit that is known, else the text.
std::string symbol_of(std::string_view unit);

}  // namespace hystcan::config
