// Measured or commanded records as CSV: a header row, commas, `#` lines ignored; read row by row in constant
// memory.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "config/config.h"

namespace hystcan::config {

/// Reads the columns asked for, in the order asked for, whatever else the file holds. Windows line ends are
/// accepted.
class CsvReader {
 public:
  /// Throws Error where the file can't be read or lacks a column.
  CsvReader(std::filesystem::path file, std::vector<std::string> columns);

  /// False at the end of the file. Throws Error at a hole, a row of the wrong length, or what is not a finite
  /// number.
  bool next(std::vector<double>& row);

  /// True where the file has this column.
  static bool has_column(const std::filesystem::path& file, std::string_view column);

 private:
  bool next_line();
  double number(std::size_t column, const std::string& name) const;
  [[noreturn]] void fail(std::size_t column_start, const std::string& what) const;

  std::filesystem::path file_;
  std::ifstream stream_;
  std::vector<std::string> wanted_;
  std::vector<std::size_t> where_;  ///< index in the file of each wanted column
  std::size_t width_ = 0;
  std::string line_;
  std::vector<std::string_view> fields_;
  std::size_t line_number_ = 0;
};

}  // namespace hystcan::config
