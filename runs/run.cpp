#include "runs/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "config/files/csv.h"
#include "controller/cycle_record.h"

namespace hystcan::runs {
namespace {

using controller::CycleColumn;

constexpr std::size_t block_rows = 65'536;

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return std::filesystem::absolute(file).parent_path();
}

/// Whether the CSV lies in the folder of a run, which describes it.
bool is_part(const std::filesystem::path& file) {
  std::error_code ignored;
  return file.filename().string().starts_with("cycles_") &&
         std::filesystem::exists(folder_of(file) / info_name, ignored);
}

Signal signal_of(const CycleColumn& column, const std::string& drive_unit) {
  return {.name = std::string(column.name),
          .unit = column.unit == "drive" ? drive_unit : std::string(column.unit),
          .words = words_of(column)};
}

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

}  // namespace

Run::Run(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path_, ignored)) {
    info_ = read_run_info(path_);
    parts_ = parts_of(path_);
    if (parts_.empty())
      throw Error(fmt::format("{}: has no cycles_*.csv, expected a run's folder", path_.string()));
  } else {
    parts_ = {path_};
    if (is_part(path_)) info_ = read_run_info(folder_of(path_));
  }
  header_ = CycleReader(parts_.front()).header();
  if (path_ == parts_.front() || info_.ended.empty()) look_through();
}

std::string Run::name() const {
  const std::filesystem::path plain = path_.has_filename() ? path_ : path_.parent_path();
  return plain.filename().string();
}

/// What run.json does not say, because there is none, or because the run was not closed.
void Run::look_through() {
  std::vector<std::string> names;
  for (const RunAxis& axis : info_.axes) names.push_back(axis.name);
  RunSummary summary(RunSummary::most_axes);
  for (const std::filesystem::path& part : parts_) {
    CycleReader reader(part);
    const bool has_fault = reader.add("time_s") && reader.add("state") && reader.add("fault");
    const bool has_error = has_fault && reader.add("error_um");
    std::vector<double> row;
    for (std::string_view axis; reader.next(row, axis);) {
      auto found = std::ranges::find(names, axis);
      if (found == names.end()) {
        if (names.size() == RunSummary::most_axes)
          throw Error(
              fmt::format("{}:1: more than {} axes, expected fewer", part.string(), RunSummary::most_axes));
        found = names.emplace(names.end(), axis);
      }
      summary.add(static_cast<std::size_t>(found - names.begin()), row[0],
                  static_cast<controller::AxisState>(row[1]),
                  has_fault ? static_cast<controller::Cause>(row[2]) : controller::Cause::none,
                  has_error ? row[3] : 0.0);
    }
  }
  for (std::size_t i = info_.axes.size(); i < names.size(); ++i)
    info_.axes.push_back({.name = names[i], .drive_unit = {}});
  summary.put_into(info_);
}

std::size_t Run::axis_index(const std::string& axis) const {
  const auto found = std::ranges::find(info_.axes, axis, &RunAxis::name);
  if (found != info_.axes.end()) return static_cast<std::size_t>(found - info_.axes.begin());
  std::vector<std::string_view> names;
  for (const RunAxis& each : info_.axes) names.push_back(each.name);
  throw Error(
      fmt::format("{}: no axis {}, expected one of {}", path_.string(), axis, fmt::join(names, ", ")));
}

std::vector<Signal> Run::signals(std::size_t axis) const {
  std::vector<Signal> signals;
  for (const std::string& name : header_)
    if (const CycleColumn* column = controller::find_cycle_column(name);
        column != nullptr && column->kind != CycleColumn::Kind::axis)
      signals.push_back(signal_of(*column, info_.axes.at(axis).drive_unit));
  return signals;
}

std::vector<Signal> Run::signals(std::size_t axis, std::span<const std::string> names) const {
  std::vector<Signal> signals(names.size());
  std::ranges::transform(names, signals.begin(), [&](const std::string& name) {
    const CycleColumn* column = controller::find_cycle_column(name);
    return column == nullptr ? Signal{} : signal_of(*column, info_.axes.at(axis).drive_unit);
  });
  return signals;
}

Columns Run::read(std::size_t axis, std::span<const std::string> names, const TimeSpan& span) const {
  Columns columns(names.size());
  read_blocks({&axis, 1}, names, span, [&](std::size_t, std::span<const std::vector<double>> block) {
    for (std::size_t i = 0; i < block.size(); ++i)
      columns[i].insert(columns[i].end(), block[i].begin(), block[i].end());
  });
  return columns;
}

void Run::read_blocks(std::span<const std::size_t> axes, std::span<const std::string> names,
                      const TimeSpan& span, const Block& take) const {
  std::vector<std::vector<std::vector<double>>> blocks(axes.size(),
                                                       std::vector<std::vector<double>>(names.size()));
  const auto pass_on = [&](std::size_t i) {
    if (names.empty() || blocks[i].front().empty()) return;
    take(axes[i], blocks[i]);
    for (auto& column : blocks[i]) column.clear();
  };
  for (const std::filesystem::path& part : parts_)
    read_part(part, names, span, [&](std::string_view name, const std::vector<double>& row) {
      const auto found =
          std::ranges::find_if(axes, [&](std::size_t axis) { return info_.axes[axis].name == name; });
      if (found == axes.end()) return;
      const auto i = static_cast<std::size_t>(found - axes.begin());
      for (std::size_t column = 0; column < names.size(); ++column)
        blocks[i][column].push_back(row[column + 1]);
      if (!names.empty() && blocks[i].front().size() == block_rows) pass_on(i);
    });
  for (std::size_t i = 0; i < axes.size(); ++i) pass_on(i);
}

/// Rows of all axes: time_s, then the columns.
void Run::read_part(const std::filesystem::path& part, std::span<const std::string> names,
                    const TimeSpan& span,
                    const std::function<void(std::string_view, const std::vector<double>&)>& take) const {
  CycleReader reader(part);
  reader.add("time_s");
  for (const std::string& name : names)
    if (!reader.add(name))
      throw Error(fmt::format("{}: no column {}, expected it in its header", part.string(), name));
  std::vector<double> row;
  for (std::string_view axis; reader.next(row, axis);) {
    if (row[0] > span.to_s) return;
    if (row[0] >= span.from_s) take(axis, row);
  }
}

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
      value = text.empty() ? std::numeric_limits<double>::quiet_NaN() : parsed_number<double>(text);
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
