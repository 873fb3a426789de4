// Reads CSV as laboratories write it. The header is found by the numbers below it:
//
//   - separators: semicolon, tab, comma or blanks; decimal commas unless commas separate
//   - lines of text before the header (instrument, date) are passed over, as are `#` lines
//   - a sampling rate stated above the header is found: `Abtastrate: 5000 Hz`, `# sample rate = 5 kHz`,
//     `Sampling rate;5000`
//   - names may be quoted and have their unit beside them: `drive (V)`, `x [um]`, `time_s`; a line of units
//     may follow
//   - without a header the columns are named 1, 2, 3 ...
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/files/csv.h"

namespace hystcan::config {

struct CsvColumn {
  std::string title;  ///< as in the file, without quotes
  std::string name;   ///< without the unit
  std::string unit;   ///< as in the file; empty: none
};

/// A name and the unit in parentheses or brackets behind it, or behind an underscore or a slash if it is a
/// known one.
CsvColumn csv_column(std::string_view title);

std::string lower_case(std::string_view text);  ///< of letters in ASCII

struct StatedRate {
  double rate_Hz = 0.0;
  std::string line;  ///< as in the file
};
/// The sampling rate that a line states, if it is one of these; none where a point may separate thousands
/// (5.000 Hz).
std::optional<StatedRate> stated_rate(std::string_view line);

class LabCsvReader {
 public:
  /// Throws Error if the file cannot be read, or if no numbers are found in it.
  explicit LabCsvReader(std::filesystem::path file);

  const std::filesystem::path& file() const { return lines_.file(); }
  const std::vector<CsvColumn>& columns() const { return columns_; }
  bool has_header() const { return has_header_; }
  /// The columns of next(), as indices of columns().
  void select(std::vector<std::size_t> columns) { selected_ = std::move(columns); }

  /// Returns false at the end of the file. Throws Error at an empty field, at a row of the wrong length, and
  /// at a value that is not a finite number.
  bool next(std::vector<double>& row);

  /// The one above the header; none where two differ.
  const std::optional<StatedRate>& rate() const { return rate_; }
  std::string comment(std::string_view name) const { return lines_.comment(name); }
  /// True if the last row that was read ends the file without a line end: it may be incomplete.
  bool ends_in_mid_line() const { return lines_.end_in_mid_line(); }
  std::size_t line_number() const { return lines_.number(); }
  /// At the header, for a message about it.
  [[noreturn]] void fail_at_header(const std::string& what) const;

 private:
  void find_header();
  void read_names(const std::vector<CsvLines::Kept>& before, std::size_t fields);
  enum class Likeness { none, some, full };  // of a line to a row: numbers among text, or nothing but numbers
  Likeness row_likeness(std::string_view line, char separator);

  CsvLines lines_;
  std::vector<CsvColumn> columns_;
  bool has_header_ = false;
  std::optional<StatedRate> rate_;
  std::size_t header_line_ = 1;
  char separator_ = ',';
  std::vector<std::size_t> selected_;
  std::vector<std::string_view> fields_;
};

}  // namespace hystcan::config
