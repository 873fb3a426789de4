#include "config/files/csv_column.h"

#include <cstddef>
#include <utility>

#include "config/files/csv.h"
#include "config/files/record_words.h"

namespace hystcan::config {
namespace {

/// Returns true if the word after the separator `mark` looks like a unit but is not one: the A of "Channel A"
/// is not ampere, and the min of "drive min" is not minutes. `mark` begins at the position `at` of `text`.
bool is_letter_of_a_channel(std::string_view text, std::string_view mark, std::size_t at) {
  const std::string_view word = text.substr(at + mark.size());
  const bool may_be_letter = mark == " " || mark == "-" || mark == "." || mark == ":";
  return may_be_letter && (word.size() < 2 || word == "min");
}

}  // namespace

std::string without_quotes(std::string_view text) {
  if (text.size() >= 2 && (text.front() == '"' || text.front() == '\'') && text.back() == text.front())
    text = text.substr(1, text.size() - 2);
  return std::string(trimmed(text));
}

std::string symbol_of(std::string_view unit) {
  const UnitWord* known = find_unit(unit);
  return known == nullptr ? std::string(unit) : std::string(known->symbol);
}

CsvColumn csv_column(std::string_view title) {
  CsvColumn column{.title = without_quotes(title)};
  const std::string text = with_u(column.title);
  column.name = text;
  for (const auto& [open, close] :
       {std::pair{'(', ')'}, std::pair{'[', ']'}, std::pair{'<', '>'}, std::pair{'{', '}'}})
    if (const auto at = text.find_last_of(open); at != std::string::npos && text.back() == close) {
      column.name = trimmed(std::string_view(text).substr(0, at));
      column.unit = symbol_of(trimmed(std::string_view(text).substr(at + 1, text.size() - at - 2)));
      if (is_clock_form(column.unit)) column.unit.clear();
      return column;
    }
  for (const std::string_view mark : {" in ", "/", "_", ", ", "-", ".", ":", " "})
    if (const auto at = text.rfind(mark);
        at != std::string::npos && at > 0 && !is_letter_of_a_channel(text, mark, at))
      if (const UnitWord* unit = find_unit(trimmed(std::string_view(text).substr(at + mark.size())))) {
        column.name = trimmed(std::string_view(text).substr(0, at));
        column.unit = unit->symbol;
        return column;
      }
  return column;
}

}  // namespace hystcan::config
