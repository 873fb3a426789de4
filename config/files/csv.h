// Measured or commanded records as CSV: a header row, commas, `#` lines ignored; read row by row in constant
// memory. Where the header has semicolons or tabs and no comma, these separate the fields, and a decimal
// comma is read as a point.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "config/document/error.h"

namespace hystcan::config {

/// Reads the columns asked for, in the order asked for, whatever else the file holds. Windows line ends are
/// accepted.
class CsvReader {
 public:
  /// Throws Error where the file can't be read, lacks a column, or has a name twice.
  CsvReader(std::filesystem::path file, std::vector<std::string> columns);

  /// Asks for one column more, where the file has it: says whether.
  bool also(const std::string& column);

  /// False at the end of the file. Throws Error at a hole, a row of the wrong length, or what is not a finite
  /// number.
  bool next(std::vector<double>& row);

  /// What a line `# NAME = TEXT` before the header says; empty where there is none.
  std::string comment(std::string_view name) const;

  /// The line read last was the file's last, and no line end follows: it may have been cut.
  bool ends_in_mid_line() const { return stream_.eof(); }

  std::uint64_t bytes_read() const { return bytes_read_; }
  std::size_t line_number() const { return line_number_; }

 private:
  bool next_line();
  std::size_t look_up(const std::string& column) const;
  double number(std::size_t column, const std::string& name) const;
  [[noreturn]] void fail(std::size_t column_start, const std::string& what) const;

  std::filesystem::path file_;
  std::ifstream stream_;
  std::vector<std::string> wanted_;
  std::vector<std::size_t> where_;  ///< index in the file of each wanted column
  std::vector<std::string> header_;
  std::vector<std::string> comments_;  ///< before the header
  char separator_ = ',';
  std::string line_;
  std::vector<std::string_view> fields_;
  std::size_t line_number_ = 0;
  std::uint64_t bytes_read_ = 0;
};

}  // namespace hystcan::config
