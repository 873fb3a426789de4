#include "config/files/row_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>
#include <unordered_map>

#include "config/files/clock_time.h"
#include "config/files/csv.h"
#include "config/files/number_signs.h"

namespace hystcan::config {
namespace {

/// A larger text is looked at in three places.
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

  /// The most frequent one with so many numbers at least.
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
  if (fields.size() == width + 1) return fields.back().empty();
  return fields.size() == width || (fields.size() + 1 == width && !shape.numbers.back());
}

}  // namespace hystcan::config
