// Reads measured or commanded signals from a CSV file, row by row in constant memory. The file has a header
// row. Commas separate the fields; lines that begin with `#` are comments. If the header has no comma, but
// semicolons or tabs, then the semicolons or tabs separate the fields, and a decimal comma is accepted. The
// number of rows is not limited.
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace hystcan::controller {
class MonotoneCubic;
}

namespace hystcan::config {

inline constexpr std::size_t most_columns = 4096;
inline constexpr std::size_t longest_csv_line = 1'048'576;  ///< maximum length of a line, bytes
/// Maximum number of comment lines before the header that are stored for comment(); further lines are
/// ignored.
inline constexpr std::size_t most_comments = 1000;
inline constexpr std::size_t longest_comment = 1024;  ///< maximum length of a stored comment line, bytes

/// open_input() and read_regular_file() name this as the expected content in their error messages.
inline constexpr const char* a_csv_file = "a CSV file";

/// Returns the text without blanks and tabs at both ends.
std::string_view trimmed(std::string_view text);

/// Splits a line into fields, without blanks and tabs at their ends. A separator within double quotes is part
/// of the field. The separator `' '` stands for any number of blanks and tabs.
void split_fields(std::string_view line, char separator, std::vector<std::string_view>& fields);

/// Returns the text without enclosing double quotes, and without blanks directly inside the quotes.
std::string_view unquoted(std::string_view text);

/// Parses a number, including nan and inf, with or without quotes. Returns nullopt if the text is not exactly
/// one number.
std::optional<double> csv_number(std::string_view text, bool decimal_comma);

/// Returns the text with each control character replaced by a space. A control character could end the line
/// or change the terminal.
std::string in_one_line(std::string_view text);
/// Returns the text as a CSV field in one line (RFC 4180): in quotes if it has a comma or a quote, with each
/// of its quotes doubled.
std::string csv_field(std::string_view text);
/// Returns TEXT of the first comment `# NAME = TEXT`, without quotes; empty if there is none.
std::string comment_in(const std::vector<std::string>& comments, std::string_view name);

/// Returns the text for a message. If the text is long, returns only its beginning.
std::string shortened(std::string_view text);
/// Returns the names as a list for a message. If there are many names, the list has only the first ones and
/// the number of the others.
std::string listed(const std::vector<std::string>& names);

/// Returns the notes about an ignored end of a file: the last row if it has no line end (`is_cut`), and the
/// number of zero bytes at the end.
std::vector<std::string> notes_of_end(bool is_cut, std::size_t zeros);

/// Reads a text file line by line. Removes line ends (of Linux and Windows) and the byte order mark that
/// Excel writes. Skips empty lines and comments (lines that begin with #).
class CsvLines {
 public:
  /// Opens the file, which may be a pipe (base/input_file.h). Throws Error if it can't be opened.
  CsvLines(std::filesystem::path file);
  /// Reads the lines from `text`. `file` is only the name in messages.
  CsvLines(std::filesystem::path file, std::string text);

  /// Reads the next line. Returns false at the end of the file. Omits a last line without a line end, which a
  /// crash may have cut, unless it is the only line. Throws Error if a line is longer than longest_csv_line.
  bool next();
  /// Returns the present line; the view is valid until the next call of next().
  std::string_view text() const { return line_; }
  std::size_t number() const { return line_number_; }
  const std::filesystem::path& file() const { return file_; }

  /// Tells next() to store no further comments: comment() returns only comments above the header.
  void end_comments() { keeps_comments_ = false; }
  /// Returns TEXT of a stored comment `# NAME = TEXT`; empty if there is none.
  std::string comment(std::string_view name) const;

  /// Returns a sentence for each part at the end of the file that next() ignored: an incomplete last line,
  /// zero bytes.
  std::vector<std::string> notes() const { return notes_of_end(is_cut_, zeros_); }
  std::uint64_t bytes_read() const { return bytes_read_; }

  /// Throws Error with file, line and column. The column is the position of `at`, a part of the present line.
  [[noreturn]] void fail(std::string_view at, const std::string& what) const;
  /// Throws Error with file and line; the column is the beginning of the present line.
  [[noreturn]] void fail(const std::string& what) const { fail(line_, what); }

 private:
  bool read_line();

  std::filesystem::path file_;
  std::unique_ptr<std::istream> stream_;
  std::vector<std::string> comments_;
  bool keeps_comments_ = true;
  std::unique_ptr<char[]> buffer_;  ///< room for the longest line, 1 MiB; unused pages take no memory
  std::string_view line_;
  std::size_t line_number_ = 0;
  bool has_content_ = false, ends_in_mid_line_ = false, is_cut_ = false;
  std::size_t zeros_ = 0;  ///< number of zero bytes at the end of the file
  std::uint64_t bytes_read_ = 0;
};

/// Throws Error if the present line does not have `expected` fields, the number of fields in the header.
void require_width(const CsvLines& lines, std::size_t fields, std::size_t expected, char separator);
/// Parses a field of the present line. Throws Error with the place of the field if it is empty or not a
/// finite number.
double finite_number(const CsvLines& lines, std::string_view field, const std::string& name, char separator);

/// Reads the requested columns of a CSV file, in the requested order. Ignores all other columns. Accepts the
/// line ends of Windows.
class CsvReader {
 public:
  /// Reads the header. Throws Error if one of `columns` is missing or a column name occurs twice.
  CsvReader(CsvLines lines, std::vector<std::string> columns);

  /// Adds a column to the columns that next() reads, if the file has this column. Returns true if the file
  /// has it.
  bool add_if_present(const std::string& column);

  /// Reads the values of the requested columns in the next row. Returns false at the end of the file, and at
  /// a last row without a line end, which is ignored. Throws Error if a requested field is empty or not a
  /// finite number, if the row has a wrong number of fields, or if the line is too long.
  bool next(std::vector<double>& row);

  /// Returns TEXT of a line `# NAME = TEXT` before the header; empty if there is none.
  std::string comment(std::string_view name) const { return lines_.comment(name); }

  /// Returns a sentence for each part at the end of the file that next() ignored: an incomplete last row,
  /// zero bytes.
  std::vector<std::string> notes() const { return lines_.notes(); }
  std::uint64_t bytes_read() const { return lines_.bytes_read(); }
  std::size_t line_number() const { return lines_.number(); }

 private:
  void require_distinct_columns() const;
  std::size_t look_up(const std::string& column) const;

  CsvLines lines_;
  std::vector<std::string> wanted_;
  std::vector<std::size_t> where_;  ///< for each name in wanted_, the index of its column in the file
  std::vector<std::string> header_;
  char separator_ = ',';
  std::vector<std::string_view> fields_;
};

/// Reads a reference from the columns time_s and position_um of a CSV file. No row is ignored, because a
/// reference is a command. Throws Error with the line if the file can't be read, if it has fewer than two
/// rows, if a row is incomplete, or if the time does not increase.
controller::MonotoneCubic load_setpoint(const std::filesystem::path& file);

}  // namespace hystcan::config
