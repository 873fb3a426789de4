// Reads measured or commanded signals from CSV, row by row in constant memory. The file has a header row
// and commas; `#` lines are ignored. If the header has semicolons or tabs and no comma, these separate the
// fields, and a decimal comma is read as a point. The number of rows has no limit.
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/document/error.h"

namespace hystcan::config {

inline constexpr std::size_t most_columns = 4096;
inline constexpr std::size_t longest_csv_line = 1'048'576;  ///< bytes
/// Lines before the header in which comment() looks.
inline constexpr std::size_t most_comments = 1000;
inline constexpr std::size_t longest_comment = 1024;  ///< bytes

/// Reads the requested columns in the requested order and ignores all others. Accepts Windows line ends.
class CsvReader {
 public:
  /// Throws Error if the file cannot be read, lacks a column, or has a column name twice. The file may be a pipe
  /// (can/input_stream.h).
  CsvReader(std::filesystem::path file, std::vector<std::string> columns);
  /// Reads a text instead; `file` is only its name in messages.
  CsvReader(std::filesystem::path file, std::string text, std::vector<std::string> columns);

  /// Requests one more column if the file has it; returns whether it has.
  bool add_if_present(const std::string& column);

  /// Returns false at the end of the file. Throws Error at an empty field, at a row of the wrong length,
  /// and at a value that is not a finite number. Also throws Error beyond the limits above.
  bool next(std::vector<double>& row);

  /// The TEXT of a line `# NAME = TEXT` before the header; empty if there is none.
  std::string comment(std::string_view name) const;

  /// True if the last line that was read ends the file without a line end: it may be incomplete.
  bool ends_in_mid_line() const { return stream_->eof(); }

  std::uint64_t bytes_read() const { return bytes_read_; }
  std::size_t line_number() const { return line_number_; }

 private:
  void read_header();
  bool next_line();
  bool read_line();
  void require_distinct_columns() const;
  std::size_t look_up(const std::string& column) const;
  double number(std::size_t column, const std::string& name) const;
  [[noreturn]] void fail(std::size_t column_start, const std::string& what) const;

  std::filesystem::path file_;
  std::unique_ptr<std::istream> stream_;
  std::vector<std::string> wanted_;
  std::vector<std::size_t> where_;  ///< index in the file of each wanted column
  std::vector<std::string> header_;
  std::vector<std::string> comments_;  ///< lines before the header
  char separator_ = ',';
  std::unique_ptr<char[]> buffer_;  ///< of the longest line; the system provides only what is used
  std::string_view line_;
  std::vector<std::string_view> fields_;
  std::size_t line_number_ = 0;
  std::uint64_t bytes_read_ = 0;
};

}  // namespace hystcan::config
