#include "runs/export.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/input_file.h"
#include "base/text.h"
#include "config/files/csv.h"
#include "controller/control/gate.h"
#include "controller/cycle_record.h"
#include "storage/hdf5.h"

namespace hystcan::runs {
namespace {

constexpr std::size_t enough_bytes = 1 << 18;

void append_value(std::string& text, const Signal& signal, double value) {
  if (std::isnan(value)) return;
  if (signal.words.empty()) return append_shortest(text, value);
  const auto index = static_cast<std::size_t>(value);
  if (signal.name == "limits")
    text += controller::limits_to_string(static_cast<std::uint8_t>(index));
  else
    text += signal.words.at(index);
}

using storage::Hdf5Writer;

constexpr std::size_t largest_config_file = 64 << 20;  // bytes

void write_info(const Run& run, Hdf5Writer& file) {
  const nlohmann::json info = to_json(run.info());
  file.set("/", "run_json", info.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  file.set("/", "run", run.name());
  for (const auto& [name, value] : info.items()) {
    if (value.is_string()) file.set("/", name, value.get<std::string>());
    if (value.is_number()) file.set("/", name, value.get<double>());
  }
}

void write_config(const Run& run, Hdf5Writer& file) {
  std::error_code error;
  for (std::filesystem::directory_iterator entry(run.path() / "config", error), end; !error && entry != end;
       entry.increment(error))
    if (entry->is_regular_file())
      file.add_text("/config/" + entry->path().filename().string(),
                    read_regular_file(entry->path(), largest_config_file));
}

/// Throws Error if the axis's name can't be the name of a HDF5 group: in HDF5 a slash separates a group from
/// its sub-group, and a dot is the group itself.
void require_group_name(const Run& run, const std::string& axis) {
  if (axis.empty() || axis == "." || axis.find('/') != std::string::npos)
    throw Error(run.path(), fmt::format("axis \"{}\" cannot be the name of an HDF5 group", axis),
                {.remedy = "export it as CSV"});
}

void describe_axis(const RunAxis& axis, Hdf5Writer& file) {
  const std::string group = "/" + axis.name;
  file.set(group, "drive_unit", axis.drive_unit);
  file.set(group, "stroke_um", axis.stroke_um);
  file.set(group, "error_rms_um", axis.rms_um);
  file.set(group, "error_max_um", axis.max_um);
}

/// Returns the axes of the run. Throws Error if the run has no axes: the run ended before its first cycle, or
/// the CSV has only a header.
const std::vector<RunAxis>& axes_in(const Run& run) {
  if (run.info().axes.empty()) throw Error(run.path(), "has no axes and no rows", expect("a run"));
  return run.info().axes;
}

}  // namespace

std::size_t axis_of(const Run& run, const std::optional<std::string>& axis) {
  const std::vector<RunAxis>& axes = axes_in(run);
  if (axis) return run.axis_index(*axis);
  if (axes.size() == 1) return 0;
  throw Error(
      run.path(), fmt::format("has {} axes", axes.size()),
      {.remedy = fmt::format("select one with --axis: {}", fmt::join(run.info().axis_names(), ", "))});
}

std::vector<std::size_t> axes_of(const Run& run, const Selection& selection) {
  std::vector<std::size_t> all(axes_in(run).size());
  if (selection.axis) return {run.axis_index(*selection.axis)};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  return all;
}

std::vector<std::string> signals_of(const Run& run, std::size_t axis, const Selection& selection) {
  std::vector<std::string> names{"time_s"};
  const std::vector<Signal> present = run.signals(axis);
  const auto add = [&](const std::string& name) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  for (const std::string& name : selection.signals) {
    if (std::ranges::find(present, name, &Signal::name) != present.end()) {
      add(name);
      continue;
    }
    std::vector<std::string> known(present.size());
    std::ranges::transform(present, known.begin(), &Signal::name);
    throw Error(run.path(), fmt::format("no signal {}", name), expect("one of {}", fmt::join(known, ", ")));
  }
  if (selection.signals.empty())
    for (const Signal& signal : present) add(signal.name);
  return names;
}

void require_rows(const Run& run, std::uint64_t rows) {
  if (rows == 0)
    throw Error(run.path(), "no rows are selected",
                expect("rows between {:g} and {:g} s", run.info().first_s, run.info().last_s));
}

std::uint64_t export_csv(const Run& run, const Selection& selection,
                         const std::function<void(std::string_view)>& write) {
  const std::size_t axis = axis_of(run, selection.axis);
  const std::vector<std::string> names = signals_of(run, axis, selection);
  const std::vector<Signal> signals = run.signals(axis, names);
  std::string text = fmt::format("# run {}, axis {}\n", config::in_one_line(run.name()),
                                 config::in_one_line(run.info().axes[axis].name));
  for (const Signal& signal : signals)
    if (!signal.unit.empty())
      text += fmt::format("# {}_unit = \"{}\"\n", signal.name, config::in_one_line(signal.unit));
  text += fmt::format("{}\n", fmt::join(names, ","));
  std::uint64_t rows = 0;
  run.read_blocks({&axis, 1}, names, selection.span,
                  [&](std::size_t, std::span<const std::vector<double>> columns) {
                    for (std::size_t row = 0; row < columns.front().size(); ++row) {
                      for (std::size_t i = 0; i < columns.size(); ++i) {
                        if (i > 0) text += ',';
                        append_value(text, signals[i], columns[i][row]);
                      }
                      text += '\n';
                      if (text.size() < enough_bytes) continue;
                      write(text);
                      text.clear();
                    }
                    rows += columns.front().size();
                  });
  require_rows(run, rows);
  write(text);
  return rows;
}

std::uint64_t export_hdf5(const Run& run, const Selection& selection, Hdf5Writer& file) {
  write_info(run, file);
  write_config(run, file);
  const std::vector<std::size_t> axes = axes_of(run, selection);
  const std::vector<std::string> names = signals_of(run, axes.front(), selection);
  std::vector<std::size_t> tables(run.info().axes.size());
  for (const std::size_t axis : axes) {
    require_group_name(run, run.info().axes[axis].name);
    std::vector<Signal> columns = run.signals(axis, names);
    for (Signal& column : columns)
      if (column.name == "limits") column.words.clear();  // "limits" is a bit mask, not an enumeration
    tables[axis] = file.add_table("/" + run.info().axes[axis].name, columns, true);
    describe_axis(run.info().axes[axis], file);
  }
  std::uint64_t rows = 0;
  run.read_blocks(axes, names, selection.span,
                  [&](std::size_t axis, std::span<const std::vector<double>> columns) {
                    file.append(tables[axis], columns);
                    rows += columns.front().size();
                  });
  require_rows(run, rows);
  return rows;
}

}  // namespace hystcan::runs
