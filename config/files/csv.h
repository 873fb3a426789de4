// Reads measured or commanded signals from CSV, row by row in constant memory. The file has a header row and
// commas; `#` lines are ignored. If the header has semicolons or tabs and no comma, these separate the
// fields, and a decimal comma is accepted. The number of rows is not limited.
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
inline constexpr std::size_t longest_csv_line = 1'048'576;  ///< bytes
/// Number of lines before the header that comment() searches.
inline constexpr std::size_t most_comments = 1000;
inline constexpr std::size_t longest_comment = 1024;  ///< bytes

/// The expected content in the errors of open_input().
inline constexpr const char* a_csv_file = "a CSV file";

/// Removes blanks and tabs at both ends.
std::string_view trimmed(std::string_view text);

/// Splits a line into trimmed fields. A separator between double quotes does not separate. The separator
/// `' '` stands for any number of blanks and tabs.
void split_fields(std::string_view line, char separator, std::vector<std::string_view>& fields);

/// Removes enclosing double quotes, and the blanks inside them.
std::string_view unquoted(std::string_view text);

/// Parses a number, including nan and inf, with or without quotes. nullopt if the text is not exactly one
/// number.
std::optional<double> csv_number(std::string_view text, bool decimal_comma);

/// Replaces each control character, which could end the line or control the terminal, by a space.
std::string in_one_line(std::string_view text);
/// Returns the text in one line as a CSV field (RFC 4180): quoted if necessary, with its own quotes doubled.
std::string csv_field(std::string_view text);
/// Returns TEXT of the first comment `# NAME = TEXT`, without quotes; empty if there is none.
std::string comment_in(const std::vector<std::string>& comments, std::string_view name);

/// Returns the beginning of a long text, for a message.
std::string shortened(std::string_view text);
/// Returns the first of many names, for a message.
std::string listed(const std::vector<std::string>& names);

/// Returns the notes about a last row without a line end, and about zeros after it.
std::vector<std::string> notes_of_end(bool is_cut, std::size_t zeros);

/// Reads lines, without their line ends (also Windows') and without Excel's byte order mark. Skips empty
/// lines and comments (lines that begin with #).
class CsvLines {
 public:
  /// The file may be a pipe (base/input_file.h). Throws Error if it can't be read.
  CsvLines(std::filesystem::path file);
  /// Reads a text instead; `file` is only its name in messages.
  CsvLines(std::filesystem::path file, std::string text);

  /// Reads the next line. Returns false at the end of the file. Omits a last line without a line end (a crash
  /// may have cut it), unless it is the only line. Throws Error if a line is longer than longest_csv_line.
  bool next();
  /// The present line; valid until next().
  std::string_view text() const { return line_; }
  std::size_t number() const { return line_number_; }
  const std::filesystem::path& file() const { return file_; }

  /// Stops storing comments.
  void end_comments() { keeps_comments_ = false; }
  /// Returns TEXT of a stored comment `# NAME = TEXT`; empty if there is none.
  std::string comment(std::string_view name) const;

  /// Returns one sentence for each thing that next() omitted.
  std::vector<std::string> notes() const { return notes_of_end(is_cut_, zeros_); }
  std::uint64_t bytes_read() const { return bytes_read_; }

  /// Throws Error with the place; `at` points into the present line.
  [[noreturn]] void fail(std::string_view at, const std::string& what) const;
  /// Throws Error at the beginning of the line.
  [[noreturn]] void fail(const std::string& what) const { fail(line_, what); }

 private:
  bool read_line();

  std::filesystem::path file_;
  std::unique_ptr<std::istream> stream_;
  std::vector<std::string> comments_;
  bool keeps_comments_ = true;
  std::unique_ptr<char[]> buffer_;  ///< sized for the longest line; the system allocates only the used pages
  std::string_view line_;
  std::size_t line_number_ = 0;
  bool has_content_ = false, ends_in_mid_line_ = false, is_cut_ = false;
  std::size_t zeros_ = 0;  ///< number of zero bytes at the end of the file
  std::uint64_t bytes_read_ = 0;
};

/// Throws Error at the present line if it does not have the header's number of fields.
void require_width(const CsvLines& lines, std::size_t fields, std::size_t expected, char separator);
/// Parses a field of the present line. Throws Error at the field if it is empty or not a finite number.
double finite_number(const CsvLines& lines, std::string_view field, const std::string& name, char separator);

/// Reads the requested columns in the requested order and ignores all others. Accepts Windows line ends.
class CsvReader {
 public:
  /// Throws Error if a column is missing or a column name occurs twice.
  CsvReader(CsvLines lines, std::vector<std::string> columns);

  /// Requests one more column if the file has it. Returns true if the file has it.
  bool add_if_present(const std::string& column);

  /// Returns false at the end of the file, and at a last row without a line end, which is omitted. Throws
  /// Error at an empty field, at a row of the wrong length, at a value that is not a finite number, and
  /// if the file exceeds a limit of this header.
  bool next(std::vector<double>& row);

  /// Returns TEXT of a line `# NAME = TEXT` before the header; empty if there is none.
  std::string comment(std::string_view name) const { return lines_.comment(name); }

  /// Returns one sentence for each thing that was omitted at the end.
  std::vector<std::string> notes() const { return lines_.notes(); }
  std::uint64_t bytes_read() const { return lines_.bytes_read(); }
  std::size_t line_number() const { return lines_.number(); }

 private:
  void require_distinct_columns() const;
  std::size_t look_up(const std::string& column) const;

  CsvLines lines_;
  std::vector<std::string> wanted_;
  std::vector<std::size_t> where_;  ///< index in the file of each wanted column
  std::vector<std::string> header_;
  char separator_ = ',';
  std::vector<std::string_view> fields_;
};

/// Reads a reference from the columns time_s and position_um. A reference is a command: no row may be
/// omitted. Throws Error with the line if the file can't be read, has fewer than two rows or an incomplete
/// last row, or if time does not increase.
controller::MonotoneCubic load_setpoint(const std::filesystem::path& file);

}  // namespace hystcan::config
