#include "runs/run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "config/files/csv.h"
#include "controller/cycle_record.h"
#include "runs/cycle_reader.h"
#include "runs/run_folder.h"
#include "runs/run_summary.h"

namespace hystcan::runs {
namespace {

using controller::CycleColumn;

constexpr std::size_t block_rows = 65'536;

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return std::filesystem::absolute(file).parent_path();
}

/// Returns true if the CSV is a part of a run: its folder has a run.json, which describes the run.
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

/// Returns notes about what a crash left at the end of a CSV: an incomplete row, or zero bytes.
std::vector<std::string> notes_of_end(const std::filesystem::path& part) {
  std::ifstream stream(part, std::ios::binary);
  constexpr std::streamoff tail_bytes = config::longest_csv_line;
  stream.seekg(0, std::ios::end);
  stream.seekg(-std::min<std::streamoff>(tail_bytes, stream.tellg()), std::ios::end);
  std::string end(tail_bytes, '\0');
  stream.read(end.data(), tail_bytes);
  end.resize(static_cast<std::size_t>(stream.gcount()));
  const std::size_t last = end.find_last_not_of('\0');
  const bool is_cut = last != std::string::npos && end[last] != '\n';
  return config::notes_of_end(is_cut, end.size() - (last + 1));
}

}  // namespace

Run::Run(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path_, ignored)) {
    info_ = read_run_info(path_);
    parts_ = parts_of(path_);
    if (parts_.empty()) throw Error(path_, "has no cycles_*.csv", expect("a run's folder"));
  } else {
    parts_ = {path_};
    if (is_part(path_)) info_ = read_run_info(folder_of(path_));
  }
  header_ = CycleReader(parts_.front()).header();
  if (path_ == parts_.front() || info_.ended.empty()) look_through();
}

std::vector<std::string> Run::notes() const {
  std::vector<std::string> notes;
  for (const std::filesystem::path& part : parts_)
    for (const std::string& left_out : notes_of_end(part))
      notes.push_back(fmt::format("{}: {}", part.string(), left_out));
  return notes;
}

std::string Run::name() const {
  const std::filesystem::path plain = path_.has_filename() ? path_ : path_.parent_path();
  return plain.filename().string();
}

/// Reads all rows and sets axes, errors, faults, times and the number of rows in info_. Needed for a single
/// CSV, and for a run that was not closed: its run.json lacks these values.
void Run::look_through() {
  std::vector<std::string> names = info_.axis_names();
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
          throw Error({part, 1}, fmt::format("more than {} axes", RunSummary::most_axes));
        found = names.emplace(names.end(), axis);
      }
      summary.add(static_cast<std::size_t>(found - names.begin()), row[0],
                  static_cast<controller::AxisState>(row[1]),
                  has_fault ? static_cast<controller::Cause>(row[2]) : controller::Cause::none,
                  has_error ? row[3] : 0.0);
    }
  }
  for (std::size_t i = info_.axes.size(); i < names.size(); ++i) info_.axes.push_back({.name = names[i]});
  summary.put_into(info_);
}

std::size_t Run::axis_index(const std::string& axis) const {
  const auto found = std::ranges::find(info_.axes, axis, &RunAxis::name);
  if (found != info_.axes.end()) return static_cast<std::size_t>(found - info_.axes.begin());
  throw Error(path_, fmt::format("no axis {}", axis),
              expect("one of {}", fmt::join(info_.axis_names(), ", ")));
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

/// Calls `take` for each row of the CSV `part` whose time is within `span`, with the name of the row's axis.
/// A row has the value of time_s first, then the values of the columns `names`.
void Run::read_part(const std::filesystem::path& part, std::span<const std::string> names,
                    const TimeSpan& span,
                    const std::function<void(std::string_view, const std::vector<double>&)>& take) const {
  CycleReader reader(part);
  reader.add("time_s");
  for (const std::string& name : names)
    if (!reader.add(name)) throw Error(part, fmt::format("no column {} in the header", name));
  std::vector<double> row;
  for (std::string_view axis; reader.next(row, axis);) {
    if (row[0] > span.to_s) return;
    if (row[0] >= span.from_s) take(axis, row);
  }
}

}  // namespace hystcan::runs
