#include "runs/hdf5_export.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/input_file.h"
#include "storage/hdf5.h"

namespace hystcan::runs {
namespace {

using storage::Hdf5Writer;

constexpr std::size_t largest_config_file = 64 << 20;  // bytes

/// The bits of `limits` are a number: they have no enumeration.
storage::Hdf5Column hdf5_column(const Signal& signal) {
  const bool is_enumerated = signal.name != "limits";
  return {.name = signal.name,
          .unit = signal.unit,
          .words = is_enumerated ? signal.words : std::vector<std::string>{}};
}

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

void describe_axis(const RunAxis& axis, Hdf5Writer& file) {
  const std::string group = "/" + axis.name;
  file.set(group, "drive_unit", axis.drive_unit);
  file.set(group, "stroke_um", axis.stroke_um);
  file.set(group, "error_rms_um", axis.summary.rms_um);
  file.set(group, "error_max_um", axis.summary.max_um);
}

}  // namespace

std::uint64_t export_hdf5(const Run& run, const Selection& selection, Hdf5Writer& file) {
  write_info(run, file);
  write_config(run, file);
  const std::vector<std::size_t> axes = axes_of(run, selection);
  const std::vector<std::string> names = signals_of(run, axes.front(), selection);
  std::vector<std::unique_ptr<storage::Hdf5Table>> tables(run.info().axes.size());
  for (const std::size_t axis : axes) {
    std::vector<storage::Hdf5Column> columns;
    for (const Signal& signal : run.signals(axis, names)) columns.push_back(hdf5_column(signal));
    tables[axis] =
        file.add_table("/" + run.info().axes[axis].name, columns, Hdf5Writer::Compression::deflate);
    describe_axis(run.info().axes[axis], file);
  }
  std::uint64_t rows = 0;
  run.read_blocks(axes, names, selection.span,
                  [&](std::size_t axis, std::span<const std::vector<double>> columns) {
                    tables[axis]->append(columns);
                    rows += columns.front().size();
                  });
  require_rows(run, rows);
  return rows;
}

}  // namespace hystcan::runs
