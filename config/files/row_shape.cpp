#include "config/files/row_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>

#include "config/files/clock_time.h"
#include "config/files/csv.h"
#include "config/files/number_signs.h"

namespace hystcan::config {
namespace {

/// Maximum size of a text in which all lines are examined, bytes. In a larger text, `sampled_lines` lines are
/// examined at each of three places: at the start, in the middle, and at three quarters of the text.
constexpr std::size_t whole_bytes = 1 << 20;
constexpr std::size_t sampled_lines = 2000;

struct Count {
  std::size_t rows = 0, texts = 0;
};

class ShapeCounts {
 public:
  explicit ShapeCounts(char separator) : separator_(separator) {}

  void add(const TextLine& line) {
    split_fields(line.text, separator_, fields_);
    if (fields_.size() > most_columns) return;
    std::string key(fields_.size(), '-');
    std::size_t texts = 0;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      if (is_value(fields_[i]))
        key[i] = 'n';
      else if (!fields_[i].empty())
        ++texts;
    }
    if (static_cast<std::size_t>(std::ranges::count(key, 'n')) < std::max<std::size_t>(texts, 1)) return;
    Count& count = counts_[key];
    ++count.rows;
    count.texts += texts;
  }

  /// Returns the most frequent shape that has at least `fewest_numbers` number fields. Also returns how many
  /// fields with a text, instead of a number, the lines of this shape have in total.
  std::pair<RowShape, std::size_t> best(std::ptrdiff_t fewest_numbers) const {
    const std::string* key = nullptr;
    Count most;
    const auto numbers = [](const std::string& of) { return std::ranges::count(of, 'n'); };
    for (const auto& [each, count] : counts_) {
      if (numbers(each) < fewest_numbers || count.rows < most.rows) continue;
      if (key != nullptr && count.rows == most.rows &&
          std::pair(numbers(each), each) < std::pair(numbers(*key), *key))
        continue;
      key = &each;
      most = count;
    }
    RowShape shape{.separator = separator_, .rows = most.rows};
    if (key != nullptr)
      for (const char c : *key) shape.numbers.push_back(c == 'n');
    return {shape, most.texts};
  }

 private:
  char separator_;
  std::unordered_map<std::string, Count> counts_;
  std::vector<std::string_view> fields_;
};

RowShape shape_among(const RecordText& text, const std::vector<std::size_t>& begins, std::size_t most_lines) {
  std::vector<ShapeCounts> counts;
  for (const char separator : {';', '\t', ',', '|', ' '}) counts.emplace_back(separator);
  for (const std::size_t begin : begins) {
    TextLine line{.next = begin};
    for (std::size_t n = 0; n < most_lines && text.next_content(line); ++n)
      for (ShapeCounts& each : counts) each.add(line);
  }
  for (const std::ptrdiff_t fewest : {2, 1}) {
    RowShape best;
    std::size_t texts = 0;
    for (const ShapeCounts& each : counts) {
      const auto [shape, other_texts] = each.best(fewest);
      if (shape.rows > best.rows || (shape.rows == best.rows && shape.rows > 0 && other_texts < texts)) {
        best = shape;
        texts = other_texts;
      }
    }
    if (best.rows > 0) return best;
  }
  return {};
}

/// Instruments can write a block of settings above the line of column names. Its rows can have the shape of
/// the record although they are not rows of the record. This is the maximum number of rows in such a block.
constexpr std::size_t longest_block_of_head = 9;

/// Returns true if a field that is not a number field of the shape has a text.
bool has_label(const std::vector<std::string_view>& fields, const RowShape& shape) {
  for (std::size_t i = 0; i < shape.width() && i < fields.size(); ++i)
    if (!shape.numbers[i] && !fields[i].empty() && !is_value(fields[i])) return true;
  return false;
}

/// Returns the name in a line of an instrument setting, "BlockSize" in `"BlockSize",600,600`. A setting is a
/// text that is followed by a number field. Returns an empty text if the line is not a setting.
std::string_view setting_of(const std::vector<std::string_view>& fields, const RowShape& shape) {
  std::size_t label = 0;
  while (label < shape.width() && fields[label].empty()) ++label;
  if (label == shape.width() || shape.numbers[label] || is_value(fields[label])) return {};
  std::size_t value = label + 1;
  while (value < shape.width() && fields[value].empty()) ++value;
  return value < shape.width() && shape.numbers[value] ? fields[label] : std::string_view();
}

/// Returns true if a line is probably a row of the record in which some numbers are unreadable. The first
/// number, in most records the time, must be readable; in a line with too many fields all numbers must be
/// readable.
bool is_damaged_row(const std::vector<std::string_view>& fields, const RowShape& shape) {
  for (std::size_t i = 0; i < std::min(fields.size(), shape.width()); ++i) {
    if (!shape.numbers[i]) continue;
    if (!is_value(fields[i])) return false;
    if (fits_width(fields, shape)) return true;
  }
  return fields.size() > shape.width();
}

/// Finds the first row of a record. The lines are added one by one, from the first line of the text on.
class FirstRow {
 public:
  explicit FirstRow(const RowShape& shape) : shape_(shape) {}

  bool is_found() const { return rows_ > longest_block_of_head || rows_ == shape_.rows; }
  const TextLine& before() const { return before_row_; }

  void add(const TextLine& line, const TextLine& before) {
    if (line.is_comment()) return;
    split_fields(line.text, shape_.separator, fields_);
    if (has_shape(fields_, shape_)) return add_row(before);
    if (!is_damaged_row(fields_, shape_))
      damaged_.reset();
    else if (!damaged_)
      damaged_ = before;
    if (has_texts(fields_, shape_)) add_names();
  }

 private:
  void add_row(const TextLine& before) {
    const std::string_view setting = setting_of(fields_, shape_);
    // Yokogawa instruments write rows of settings above the record. If all rows so far are settings and this
    // row is not, the record begins at this row.
    if (setting.empty() && settings_ == rows_ && settings_ > 1) reset_counts();
    if (rows_ == 0) before_row_ = damaged_.value_or(before);
    ++rows_;
    if (has_label(fields_, shape_)) ++labelled_;
    if (!setting.empty() && setting != last_setting_) ++settings_;
    last_setting_ = setting;
  }

  void add_names() {
    // This line has column names. If the rows above it are instrument settings, they are not rows of the
    // record. They may be settings if each row has a label, or if no other line of names is above them.
    const bool is_of_head = labelled_ == rows_ || !has_names_;
    if (rows_ > 0 && is_of_head && rows_ * 10 < shape_.rows) reset_counts();
    has_names_ = true;
  }

  void reset_counts() { rows_ = labelled_ = settings_ = 0; }

  const RowShape& shape_;
  std::vector<std::string_view> fields_;
  TextLine before_row_;
  /// If the present line is a damaged row (is_damaged_row()): the line before this row and before all damaged
  /// rows directly above it. Otherwise nullopt.
  std::optional<TextLine> damaged_;
  std::size_t rows_ = 0, labelled_ = 0, settings_ = 0;
  std::string_view last_setting_;
  bool has_names_ = false;
};

}  // namespace

bool is_value(std::string_view field) {
  if (field.empty()) return false;
  return is_number_like(field) || is_date(field) || clock_time(field).has_value();
}

RowShape find_row_shape(const RecordText& text) {
  const std::string_view all = text.text();
  if (all.size() > whole_bytes) {
    const auto line_behind = [&](std::size_t at) { return std::min(all.size(), all.find('\n', at) + 1); };
    RowShape shape =
        shape_among(text, {0, line_behind(all.size() / 2), line_behind(all.size() / 4 * 3)}, sampled_lines);
    if (shape.rows >= sampled_lines) return shape;
  }
  return shape_among(text, {0}, std::numeric_limits<std::size_t>::max());
}

bool has_shape(const std::vector<std::string_view>& fields, const RowShape& shape) {
  if (!fits_width(fields, shape)) return false;
  for (std::size_t i = 0; i < shape.width(); ++i)
    if (shape.numbers[i] && !is_value(fields[i])) return false;
  return true;
}

bool has_value_of(const std::vector<std::string_view>& fields, const RowShape& shape) {
  for (std::size_t i = 0; i < std::min(fields.size(), shape.width()); ++i)
    if (shape.numbers[i] && is_value(fields[i])) return true;
  return false;
}

bool has_texts(const std::vector<std::string_view>& fields, const RowShape& shape) {
  if (fields.size() + 1 < shape.width() || fields.size() > shape.width() + 1) return false;
  for (std::size_t i = 0; i < shape.width(); ++i)
    if (shape.numbers[i] && (i >= fields.size() || fields[i].empty() || is_value(fields[i]))) return false;
  return true;
}

bool fits_width(const std::vector<std::string_view>& fields, const RowShape& shape) {
  const std::size_t width = shape.width();
  if (fields.size() == width + 1) return !is_value(fields.back());
  return fields.size() == width || (fields.size() + 1 == width && !shape.numbers.back());
}

TextLine before_first_row(const RecordText& text, const RowShape& shape) {
  FirstRow first(shape);
  TextLine line;
  for (TextLine before; !first.is_found() && text.next(line); before = line) first.add(line, before);
  return first.before();
}

}  // namespace hystcan::config
