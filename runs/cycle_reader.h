// Reads a CSV of cycles (controller/cycle_record.h) row by row in constant memory. Columns are found by name:
// a file of an older version may lack some, and a file of a newer version may have more.
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

/// Returns true if the file is a CSV with the columns that every file of cycles has.
bool has_cycles(const std::filesystem::path& file);

class CycleReader {
 public:
  /// Throws Error if the file can't be read or is not a CSV of cycles.
  explicit CycleReader(std::filesystem::path file);

  /// Column names in the order of the file.
  const std::vector<std::string>& header() const { return header_; }
  /// Requests one more column by its name. Returns false if the file does not have it. Throws Error at a name
  /// that is not a column of cycles.
  bool add(std::string_view column);

  /// Returns the requested columns, and the name of the row's axis. Returns false at the end of the file, and
  /// at a last line without a line end, as left by a killed program. Throws Error at a line that is not a
  /// row: FILE:LINE:COLUMN: PROBLEM, expected ...
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
