#include "runs/cycle_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "config/files/csv.h"

namespace hystcan::runs {
namespace {

using Kind = controller::CycleColumn::Kind;

constexpr std::size_t block_bytes = 1 << 20;
static_assert(block_bytes > CycleReader::longest_line);

/// The bits of "slew+model"; empty if a name is unknown.
std::optional<double> bits_of(std::string_view text, const std::vector<std::string>& words) {
  unsigned bits = 0;
  while (!text.empty()) {
    const std::string_view name = text.substr(0, text.find('+'));
    const auto found = std::ranges::find(words, name);
    if (found == words.end()) return std::nullopt;
    bits |= 1U << (found - words.begin());
    text.remove_prefix(std::min(text.size(), name.size() + 1));
  }
  return bits;
}

std::optional<double> number_of(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

CycleReader::CycleReader(std::filesystem::path file) : file_(std::move(file)), block_(block_bytes) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file_, ignored))
    throw Error(fmt::format("{}: is no file, expected a run's folder or a CSV of cycles", file_.string()));
  stream_.open(file_, std::ios::binary);
  if (!stream_) throw Error(fmt::format("{}: cannot be read, expected a CSV of cycles", file_.string()));
  if (!next_line()) fail("no header row, expected a CSV of cycles");
  line_ = without_byte_order_mark(line_);
  split();
  header_.assign(fields_.begin(), fields_.end());
  for (const char* needed : {"cycle", "time_s", "axis", "state", "position_um"})
    if (!field_of(needed))
      fail(fmt::format("no column {}, expected a run's folder or a CSV of cycles", needed));
  axis_field_ = *field_of("axis");
}

std::optional<std::size_t> CycleReader::field_of(std::string_view column) const {
  const auto found = std::ranges::find(header_, column);
  if (found == header_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header_.begin());
}

bool CycleReader::add(std::string_view column) {
  const controller::CycleColumn* known = controller::find_cycle_column(column);
  if (known == nullptr || known->kind == Kind::axis) {
    std::vector<std::string_view> names;
    for (const auto& each : controller::cycle_columns())
      if (each.kind != Kind::axis) names.push_back(each.name);
    throw Error(
        fmt::format("no signal {}, expected one of {}", config::shortened(column), fmt::join(names, ", ")));
  }
  const auto field = field_of(column);
  if (field) wanted_.push_back({known, *field, controller::words_of(*known)});
  return field.has_value();
}

bool CycleReader::next(std::vector<double>& row, std::string_view& axis) {
  if (!next_line()) return false;
  split();
  if (fields_.size() != header_.size())
    fail(fmt::format("the row has {} fields, expected {} as in the header", fields_.size(), header_.size()));
  axis = fields_[axis_field_];
  row.resize(wanted_.size());
  std::ranges::transform(wanted_, row.begin(), [this](const Wanted& wanted) { return value(wanted); });
  return true;
}

/// The next line that is neither empty nor a comment.
bool CycleReader::next_line() {
  while (true) {
    const char* const first = block_.data() + begin_;
    const auto* const last = static_cast<const char*>(std::memchr(first, '\n', end_ - begin_));
    if (last == nullptr) {
      if (end_ - begin_ > longest_line)
        fail(fmt::format("a longer line, expected at most {} bytes", longest_line));
      std::memmove(block_.data(), first, end_ - begin_);
      end_ -= begin_;
      begin_ = 0;
      stream_.read(block_.data() + end_, static_cast<std::streamsize>(block_.size() - end_));
      if (stream_.gcount() == 0) return false;
      end_ += static_cast<std::size_t>(stream_.gcount());
      if (const auto other = refusal_of_encoding({block_.data(), end_}); line_number_ == 0 && !other.empty())
        fail(std::string(other));
      continue;
    }
    ++line_number_;
    begin_ += static_cast<std::size_t>(last - first) + 1;
    line_ = {first, static_cast<std::size_t>(last - first)};
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    if (!line_.empty() && line_.front() != '#') return true;
  }
}

void CycleReader::split() {
  fields_.clear();
  for (std::string_view rest = line_;;) {
    const auto end = rest.find(',');
    fields_.push_back(rest.substr(0, end));
    if (end == std::string_view::npos) return;
    rest.remove_prefix(end + 1);
  }
}

double CycleReader::value(const Wanted& wanted) const {
  const std::string_view text = fields_[wanted.field];
  const char* expected = "a number";
  std::optional<double> value;
  switch (wanted.column->kind) {
    case Kind::limits:
      value = bits_of(text, wanted.words);
      expected = "names of limits";
      break;
    case Kind::state:
    case Kind::cause:
      if (const auto found = std::ranges::find(wanted.words, text); found != wanted.words.end())
        value = static_cast<double>(found - wanted.words.begin());
      expected = "a name that this version knows";
      break;
    case Kind::whole:
    case Kind::number:
    case Kind::axis:
      value = text.empty() ? std::numeric_limits<double>::quiet_NaN() : number_of(text);
      break;
  }
  if (!value)
    fail(fmt::format("{} is \"{}\", expected {}", wanted.column->name, config::shortened(text), expected));
  return *value;
}

void CycleReader::fail(const std::string& what) const {
  throw Error(fmt::format("{}:{}: {}", file_.string(), std::max<std::size_t>(line_number_, 1), what));
}

}  // namespace hystcan::runs
