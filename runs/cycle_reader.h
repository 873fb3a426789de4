// Reads a CSV of cycles row by row in constant memory. A row has the values of one control cycle of one axis
// (controller/cycle_record.h). Columns are found by name: a file of an older version of hystcan may lack
// columns, and a file of a newer version may have additional columns.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/files/csv.h"
#include "controller/cycle_record.h"

namespace hystcan::runs {

/// Returns true if the file is a CSV of control cycles: its header has the columns that every such file has.
bool has_cycles(const std::filesystem::path& file);

class CycleReader {
 public:
  /// Throws Error if the file can't be read or is not a CSV of cycles.
  explicit CycleReader(std::filesystem::path file);

  /// Returns the names of all columns, in the order of the file.
  const std::vector<std::string>& header() const { return header_; }
  /// Adds a column to the columns that next() returns. Returns false if the file lacks this column. Throws
  /// Error if `column` is not the name of a column of cycles.
  bool add(std::string_view column);

  /// Reads the next row. Stores the values of the columns added by add() in `row`, and the name of the row's
  /// axis in `axis`. Returns false at the end of the file, and at a last line without a line end, which a
  /// killed program leaves. Throws Error if a line is not a valid row: FILE:LINE:COLUMN: PROBLEM, expected
  /// ...
  bool next(std::vector<double>& row, std::string_view& axis);

 private:
  struct Wanted {
    const controller::CycleColumn* column;
    std::size_t field;
    std::vector<std::string> words;
  };
  std::optional<std::size_t> field_of(std::string_view column) const;
  double value(const Wanted& wanted) const;

  config::CsvLines lines_;
  std::vector<std::string_view> fields_;
  std::vector<std::string> header_;
  std::vector<Wanted> wanted_;
  std::size_t axis_field_ = 0;
};

}  // namespace hystcan::runs
