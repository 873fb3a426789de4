// Reads measured or commanded signals from CSV, row by row in constant memory. The file has a header row
// and commas; `#` lines are ignored. If the header has semicolons or tabs and no comma, these separate the
// fields, and a decimal comma is read as a point. The number of rows has no limit.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/files/csv_lines.h"

namespace hystcan::config {

/// Reads the requested columns in the requested order and ignores all others. Accepts Windows line ends.
class CsvReader {
 public:
  /// Throws Error if the file cannot be read, lacks a column, or has a column name twice. The file may be a pipe
  /// (base/input_file.h).
  CsvReader(std::filesystem::path file, std::vector<std::string> columns);
  /// Reads a text instead; `file` is only its name in messages.
  CsvReader(std::filesystem::path file, std::string text, std::vector<std::string> columns);

  /// Requests one more column if the file has it; returns whether it has.
  bool add_if_present(const std::string& column);

  /// Returns false at the end of the file. Throws Error at an empty field, at a row of the wrong length,
  /// and at a value that is not a finite number. Also throws Error beyond the limits of csv_lines.h.
  bool next(std::vector<double>& row);

  /// The TEXT of a line `# NAME = TEXT` before the header; empty if there is none.
  std::string comment(std::string_view name) const { return lines_.comment(name); }

  /// True if the last line that was read ends the file without a line end: it may be incomplete.
  bool ends_in_mid_line() const { return lines_.end_in_mid_line(); }

  std::uint64_t bytes_read() const { return lines_.bytes_read(); }
  std::size_t line_number() const { return lines_.number(); }

 private:
  void read_header();
  void require_distinct_columns() const;
  std::size_t look_up(const std::string& column) const;

  CsvLines lines_;
  std::vector<std::string> wanted_;
  std::vector<std::size_t> where_;  ///< index in the file of each wanted column
  std::vector<std::string> header_;
  char separator_ = ',';
  std::vector<std::string_view> fields_;
};

}  // namespace hystcan::config
