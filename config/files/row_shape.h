// Determines the shape of the rows in a measured record: the separator, the number of fields, and which
// fields contain numbers. The most frequent shape in the text is the shape of the record. Lines with other
// shapes may be above the rows of the record, for example instrument settings and column names.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "config/files/record_text.h"

namespace hystcan::config {

struct RowShape {
  char separator = ',';         ///< separator of the fields; `' '` means any number of blanks and tabs
  std::vector<bool> numbers{};  ///< for each field: true if the rows have a number in this field
  std::size_t rows = 0;         ///< number of examined lines that have this shape

  std::size_t width() const { return numbers.size(); }
};

/// Returns true if the field is a number (with any decimal and thousands sign), a time of day or a date.
bool is_value(std::string_view field);

/// Returns the most frequent shape of the lines with numbers. A shape with two or more numbers has priority
/// over a shape with one number. `rows` of the result is 0 if the text has no line of numbers. If the text
/// is long, only samples of it are examined, unless the samples have too few rows.
RowShape find_row_shape(const RecordText& text);

/// Returns true if the fields have the shape: their number fits, and each number field of the shape has a
/// value (see is_value()).
bool has_shape(const std::vector<std::string_view>& fields, const RowShape& shape);
/// Returns true if at least one number field of the shape has a value (see is_value()).
bool has_value_of(const std::vector<std::string_view>& fields, const RowShape& shape);
/// Returns true if every number field of the shape has a text that is not a value, as in a line of column
/// names.
bool has_texts(const std::vector<std::string_view>& fields, const RowShape& shape);
/// Returns true if there are as many fields as in the shape. Also returns true in two other cases: the last
/// field of the shape is missing and is not a number field, or one more field follows and it is not a value.
bool fits_width(const std::vector<std::string_view>& fields, const RowShape& shape);

/// Returns the line before the first row of the record. `shape.rows` must not be 0. Rows with unreadable
/// numbers that are directly above the first complete row also belong to the record.
TextLine before_first_row(const RecordText& text, const RowShape& shape);

}  // namespace hystcan::config
