// Reads measured or commanded signals from CSV, row by row in constant memory. The file has a header row
// and commas; `#` lines are ignored. If the header has semicolons or tabs and no comma, these separate the
// fields, and a decimal comma is read as a point. The number of rows has no limit.
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
/// Lines before the header in which comment() looks.
inline constexpr std::size_t most_comments = 1000;
inline constexpr std::size_t longest_comment = 1024;  ///< bytes

/// What open_input() expects.
inline constexpr const char* a_csv_file = "a CSV file";

/// Without blanks and tabs at both ends.
std::string_view trimmed(std::string_view text);

/// The fields of a line, trimmed. A separator between double quotes does not separate. `' '`: any number of
/// blanks and tabs.
void split_fields(std::string_view line, char separator, std::vector<std::string_view>& fields);

/// Without double quotes around it, and without blanks within them.
std::string_view unquoted(std::string_view text);

/// A number, also not a finite one; quotes around it are left out. None if the text is none, or has more than
/// one.
std::optional<double> csv_number(std::string_view text, bool decimal_comma);

/// The text with a space for each control character, which would end the line or steer the terminal.
std::string in_one_line(std::string_view text);
/// The text in one line, as a field of a CSV (RFC 4180): in quotes if it needs them, its own quotes doubled.
std::string csv_field(std::string_view text);
/// The TEXT of the first comment `# NAME = TEXT`, without quotes; empty if there is none.
std::string comment_in(const std::vector<std::string>& comments, std::string_view name);

/// For a message: the beginning of a long text.
std::string shortened(std::string_view text);
/// For a message: the first of many names.
std::string listed(const std::vector<std::string>& names);

/// What is said of a last row without its line end, and of zeros behind it.
std::vector<std::string> notes_of_end(bool is_cut, std::size_t zeros);

/// Lines without their ends (also Windows') and without Excel's mark of the byte order. Lines beginning with
/// # are comments; they and empty lines are passed over.
class CsvLines {
 public:
  /// The file may be a pipe (base/input_file.h). Throws Error if it cannot be read.
  CsvLines(std::filesystem::path file);
  /// Reads a text instead; `file` is only its name in messages.
  CsvLines(std::filesystem::path file, std::string text);

  /// Goes to the next line; false at the end of the file, and at a last line behind others without its end,
  /// which a crash has cut. Throws Error at a line beyond the limit.
  bool next();
  /// The present line, valid until next().
  std::string_view text() const { return line_; }
  std::size_t number() const { return line_number_; }
  const std::filesystem::path& file() const { return file_; }

  /// From here on comments are not kept.
  void end_comments() { keeps_comments_ = false; }
  /// The TEXT of a comment `# NAME = TEXT` that was kept; empty if there is none.
  std::string comment(std::string_view name) const;

  /// What next() has left out, a sentence each.
  std::vector<std::string> notes() const { return notes_of_end(is_cut_, zeros_); }
  std::uint64_t bytes_read() const { return bytes_read_; }

  /// Throws Error with the place: `at` points into the present line.
  [[noreturn]] void fail(std::string_view at, const std::string& what) const;
  [[noreturn]] void fail(const std::string& what) const { fail(line_, what); }  ///< at its beginning

 private:
  bool read_line();

  std::filesystem::path file_;
  std::unique_ptr<std::istream> stream_;
  std::vector<std::string> comments_;
  bool keeps_comments_ = true;
  std::unique_ptr<char[]> buffer_;  ///< of the longest line; the system provides only what is used
  std::string_view line_;
  std::size_t line_number_ = 0;
  bool has_content_ = false, ends_in_mid_line_ = false, is_cut_ = false;
  std::size_t zeros_ = 0;  ///< at the end of the file
  std::uint64_t bytes_read_ = 0;
};

/// Throws Error at the present line if it has another number of fields than the header.
void require_width(const CsvLines& lines, std::size_t fields, std::size_t expected, char separator);
/// A field of the present line. Throws Error at it if it is empty or not a finite number.
double finite_number(const CsvLines& lines, std::string_view field, const std::string& name, char separator);

/// Reads the requested columns in the requested order and ignores all others. Accepts Windows line ends.
class CsvReader {
 public:
  /// Throws Error if a column is missing, or if a column name occurs twice.
  CsvReader(CsvLines lines, std::vector<std::string> columns);

  /// Requests one more column if the file has it; returns whether it has.
  bool add_if_present(const std::string& column);

  /// Returns false at the end of the file, and at a last row without its line end, which is left out. Throws
  /// Error at an empty field, at a row of the wrong length, and at a value that is not a finite number. Also
  /// throws Error beyond the limits above.
  bool next(std::vector<double>& row);

  /// The TEXT of a line `# NAME = TEXT` before the header; empty if there is none.
  std::string comment(std::string_view name) const { return lines_.comment(name); }

  /// What was left out at the end, a sentence each.
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

/// Reads a reference from the columns time_s and position_um. A reference is a command: no row is left out.
/// Throws Error, with its line, if the file cannot be read, has fewer than two rows or a row that was cut, or
/// if time does not increase.
controller::MonotoneCubic load_setpoint(const std::filesystem::path& file);

}  // namespace hystcan::config
