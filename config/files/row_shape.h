// The shape of a record's rows, determined from their numbers: the separator, the number of fields, and the
// fields with numbers. The most frequent shape is the record's; blocks with other shapes may precede it.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "config/files/record_text.h"

namespace hystcan::config {

struct RowShape {
  char separator = ',';         ///< `' '` means any number of blanks and tabs
  std::vector<bool> numbers{};  ///< for each field: true if the rows have a number there
  std::size_t rows = 0;         ///< number of examined lines with this shape

  std::size_t width() const { return numbers.size(); }
};

/// Returns true for a number with any signs, a time of day or a date.
bool is_value(std::string_view field);

/// Examines the whole text; `rows` is 0 if no line has two numbers, or one number and nothing else.
RowShape find_row_shape(const RecordText& text);

/// Returns true if every field of the shape with a number has a value.
bool has_shape(const std::vector<std::string_view>& fields, const RowShape& shape);
/// Returns true if at least one field of the shape with a number has a value.
bool has_value_of(const std::vector<std::string_view>& fields, const RowShape& shape);
/// Returns true if every field of the shape with a number has a text, as in a line of names.
bool has_texts(const std::vector<std::string_view>& fields, const RowShape& shape);
/// Returns true if the number of fields fits a row: an empty last field may be missing, and a remark may
/// follow.
bool fits_width(const std::vector<std::string_view>& fields, const RowShape& shape);

/// Returns the line before the first row; `shape.rows` must not be 0. A row with unreadable numbers also
/// counts as a row if no other line is between it and the first complete row.
TextLine before_first_row(const RecordText& text, const RowShape& shape);

}  // namespace hystcan::config
