// Reads records as laboratories and their instruments write them: CSV, or columns between blanks.
//
//   head   all lines above the rows: settings of the instrument, names, units (record_head.h)
//   rows   lines with the most frequent shape (row_shape.h), from the first one on
//   foot   lines of text below the last row
//
// The separator (semicolon, tab, comma, bar, blanks), the decimal sign and the thousands sign are decided
// once for the whole file. A row is judged when it is read and no sooner: what a caller does not use can be
// damaged.
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

  /// Throws Error if the file cannot be read, or if its numbers contradict each other in their signs.
  explicit LabCsvReader(std::filesystem::path file,
                        std::size_t most_rows = std::numeric_limits<std::size_t>::max() - most_head_lines);

  const std::filesystem::path& file() const { return text_.file(); }
  const std::vector<CsvColumn>& columns() const { return head_.columns; }
  /// Those that have numbers in most rows.
  std::vector<std::size_t> value_columns() const;
  bool has_header() const { return head_.has_names; }
  /// The columns of next(), as indices of columns(). If `first_is_time`, the first one can be times of day,
  /// which become seconds since the first one.
  void select(std::vector<std::size_t> columns, bool first_is_time = false);
  bool has_clock() const { return has_clock_; }

  /// Goes back to the first row.
  void rewind();
  /// False at the end of the file, and at a last line without its end, which may be incomplete. A number that
  /// cannot be read is NaN; then is_damaged().
  bool read(std::vector<double>& row);
  bool is_damaged() const { return damage_.has_value(); }
  Error damage_error() const { return {text_.place(line_, damage_->at), damage_->what}; }

  /// The one in the head; none where two differ.
  const std::optional<StatedRate>& rate() const { return head_.rate; }
  /// The TEXT of a line `# NAME = TEXT` in the head.
  std::string comment(std::string_view name) const;
  /// What was assumed or left out, a sentence each.
  std::vector<std::string> notes() const;
  std::size_t line_number() const { return line_.number; }
  /// At the header, for a message about it.
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
  std::size_t end_ = 0;  ///< of the rows, in the text
  TextLine line_;        ///< the present one
  std::optional<Damage> damage_;
  bool has_clock_ = false;
  ClockColumn clock_;
  bool leaves_out_last_ = false, has_foot_ = false, is_at_end_ = false;
};

}  // namespace hystcan::config
