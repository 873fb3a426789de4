// How the rows of a record look, found by the numbers in them: the separator, the number of fields, and the
// fields that have numbers. The most frequent shape is that of the record; a file has other blocks of numbers
// above it or none.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "config/files/record_text.h"

namespace hystcan::config {

struct RowShape {
  char separator = ',';         ///< `' '`: any number of blanks and tabs
  std::vector<bool> numbers{};  ///< for each field whether the rows have a number there
  std::size_t rows = 0;         ///< with this shape among the lines that were looked at

  std::size_t width() const { return numbers.size(); }
};

/// True for a number with any signs, a time of day or a date.
bool is_value(std::string_view field);

/// Of the whole text; `rows` is 0 if no line has two numbers, nor one that fills it.
RowShape find_row_shape(const RecordText& text);

/// True if the fields have values wherever the shape has them.
bool has_shape(const std::vector<std::string_view>& fields, const RowShape& shape);
/// True if a field has a value where the shape has one.
bool has_value_of(const std::vector<std::string_view>& fields, const RowShape& shape);
/// True if the fields have texts wherever the shape has values, as names do.
bool has_texts(const std::vector<std::string_view>& fields, const RowShape& shape);
/// Whether so many fields are a row: an empty one at the end may be missing, and a remark may follow.
bool fits_width(const std::vector<std::string_view>& fields, const RowShape& shape);

/// The line before the first row; `shape.rows` is not 0. A row of which not all numbers can be read is a row
/// too if no other line is between it and the first whole one.
TextLine before_first_row(const RecordText& text, const RowShape& shape);

}  // namespace hystcan::config
