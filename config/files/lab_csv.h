// Reads measured records in the formats that laboratory instruments write: CSV, or columns separated by
// blanks. A record has three sections:
//
//   head   all lines above the rows: instrument settings, names, units (record_head.h)
//   rows   lines with the most frequent shape (row_shape.h), from the first such line on
//   foot   lines of text below the last row
//
// The separator (semicolon, tab, comma, vertical bar or blanks), the decimal sign and the thousands sign are
// determined once for the whole file. A row is checked only when it is read: its number of fields, and the
// selected columns. So a caller can read a record with damage in other rows or columns.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/files/clock_time.h"
#include "config/files/number_signs.h"
#include "config/files/record_head.h"
#include "config/files/record_text.h"
#include "config/files/row_shape.h"

namespace hystcan::config {

class LabCsvReader {
 public:
  static constexpr std::size_t most_head_lines = 100'000;

  /// Reads the whole file and its head. Throws Error if the file can't be read, or if its numbers have
  /// contradictory decimal or thousands signs.
  explicit LabCsvReader(std::filesystem::path file,
                        std::size_t most_rows = std::numeric_limits<std::size_t>::max() - most_head_lines);

  const std::filesystem::path& file() const { return text_.file(); }
  const std::vector<CsvColumn>& columns() const { return head_.columns; }
  /// Returns the indices of the columns that contain numbers in most rows.
  std::vector<std::size_t> value_columns() const;
  bool has_header() const { return head_.has_names; }
  /// Selects the columns for read(). `columns` are indices in columns(). With `first_is_time`, the first
  /// selected column may contain times of day; read() converts them to seconds since the first row.
  void select(std::vector<std::size_t> columns, bool first_is_time = false);
  bool has_clock() const { return has_clock_; }

  /// Makes the next call of read() return the first row.
  void rewind();
  /// Reads the selected columns of the next row. Returns false at the end of the rows, and at a last line
  /// without a line end, which may be incomplete. A field that is not a valid number becomes NaN, and
  /// is_damaged() is then true.
  bool read(std::vector<double>& row);
  bool is_damaged() const { return damage_.has_value(); }
  Error damage_error() const { return {text_.place(line_, damage_->at), damage_->what}; }

  /// Returns the sampling rate in the head; nullopt if the head has no rate or two different rates.
  const std::optional<StatedRate>& rate() const { return head_.rate; }
  /// Returns TEXT of a line `# NAME = TEXT` in the head; empty if the head has no such line.
  std::string comment(std::string_view name) const;
  /// Returns a sentence for each assumption about the file and for each ignored part of the file.
  std::vector<std::string> notes() const;
  std::size_t line_number() const { return line_.number; }
  /// Throws Error with the message `what` and the place of the line with the column names.
  [[noreturn]] void fail_at_header(const std::string& what) const;

 private:
  struct Damage {
    std::string_view at;
    std::string what;
  };
  TextLine shape_of_names();
  void read_head_above();
  std::vector<TextLine> settings_beside();
  void find_foot();
  void leave_out_small_block();
  void find_signs();
  void refuse_split_decimals() const;
  void damage(std::string_view at, std::string what);
  double value(std::size_t i);

  RecordText text_;
  RowShape shape_;
  RecordHead head_;
  NumberSigns signs_;
  std::vector<std::size_t> selected_;
  std::vector<std::string_view> fields_;
  TextLine first_;       ///< the line before the first row
  std::size_t end_ = 0;  ///< position in the text after the last row
  TextLine line_;        ///< the present line
  std::optional<Damage> damage_;
  bool has_clock_ = false;
  ClockColumn clock_;
  bool leaves_out_last_ = false, has_foot_ = false, is_at_end_ = false;
};

}  // namespace hystcan::config
