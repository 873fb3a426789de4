#include "runs/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "config/document/error.h"
#include "controller/cycle_columns.h"
#include "runs/cycle_reader.h"
#include "runs/run_summary.h"

namespace hystcan::runs {
namespace {

using controller::CycleColumn;

constexpr std::size_t block_rows = 65'536;

Signal signal_of(const CycleColumn& column, const std::string& drive_unit) {
  return {.name = std::string(column.name),
          .unit = column.unit == "drive" ? drive_unit : std::string(column.unit),
          .words = words_of(column)};
}

}  // namespace

Run::Run(std::filesystem::path path) : path_(std::move(path)) {
  if (std::filesystem::is_directory(path_)) {
    info_ = read_run_info(path_);
    parts_ = parts_of(path_);
    if (parts_.empty())
      throw config::Error(fmt::format("{}: has no cycles_*.csv, expected a run's folder", path_.string()));
  } else {
    parts_ = {path_};
  }
  header_ = CycleReader(parts_.front()).header();
  if (info_.axes.empty() || info_.ended.empty()) look_through();
}

std::string Run::name() const {
  const std::filesystem::path plain = path_.has_filename() ? path_ : path_.parent_path();
  return plain.filename().string();
}

/// What run.json does not say, because there is none, or because nobody closed the run.
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
          throw config::Error(
              fmt::format("{}:1: more than {} axes, expected fewer", part.string(), RunSummary::most_axes));
        found = names.emplace(names.end(), axis);
      }
      summary.add({.axis = static_cast<std::size_t>(found - names.begin()),
                   .time_s = row[0],
                   .state = static_cast<controller::AxisState>(row[1]),
                   .cause = has_fault ? static_cast<controller::Cause>(row[2]) : controller::Cause::none,
                   .error_um = has_error ? row[3] : 0.0});
    }
  }
  for (std::size_t i = info_.axes.size(); i < names.size(); ++i)
    info_.axes.push_back({.name = names[i], .drive_unit = {}, .stroke_um = 0.0, .summary = {}});
  summary.put_into(info_);
}

std::size_t Run::axis_index(const std::string& axis) const {
  const auto found = std::ranges::find(info_.axes, axis, &RunAxis::name);
  if (found != info_.axes.end()) return static_cast<std::size_t>(found - info_.axes.begin());
  std::vector<std::string_view> names;
  for (const RunAxis& each : info_.axes) names.push_back(each.name);
  throw config::Error(
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

Signals Run::read(std::size_t axis, std::span<const std::string> names, const TimeSpan& span) const {
  Signals result;
  for (const std::string& name : names) {
    const CycleColumn* column = controller::find_cycle_column(name);
    result.signals.push_back(column == nullptr ? Signal{}
                                               : signal_of(*column, info_.axes.at(axis).drive_unit));
  }
  result.columns.resize(names.size());
  read_blocks(axis, names, span, [&](std::span<const std::vector<double>> block) {
    for (std::size_t i = 0; i < block.size(); ++i)
      result.columns[i].insert(result.columns[i].end(), block[i].begin(), block[i].end());
  });
  return result;
}

void Run::read_blocks(std::size_t axis, std::span<const std::string> names, const TimeSpan& span,
                      const Block& take) const {
  const std::string& axis_name = info_.axes.at(axis).name;
  std::vector<std::vector<double>> block(names.size());
  const auto pass_on = [&] {
    if (block.empty() || block.front().empty()) return;
    take(block);
    for (auto& column : block) column.clear();
  };
  for (const std::filesystem::path& part : parts_) {
    CycleReader reader(part);
    reader.add("time_s");
    for (const std::string& name : names)
      if (!reader.add(name))
        throw config::Error(fmt::format("{}: no column {}, expected it in its header", part.string(), name));
    std::vector<double> row;
    for (std::string_view of; reader.next(row, of);) {
      if (of != axis_name || row[0] < span.from_s) continue;
      if (row[0] > span.to_s) return pass_on();
      for (std::size_t i = 0; i < block.size(); ++i) block[i].push_back(row[i + 1]);
      if (block.front().size() == block_rows) pass_on();
    }
  }
  pass_on();
}

}  // namespace hystcan::runs
