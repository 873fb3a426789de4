#include "app/stage/stage_records.h"

#include <fmt/format.h>

#include <cmath>

#include <algorithm>
#include <string>

#include "base/error.h"
#include "model/any_model.h"

namespace hystcan::app {
namespace {

using identification::Dataset;
using model::Interval;

Interval extremes(const std::vector<double>& values) {
  const auto [least, most] = std::ranges::minmax(values);
  return {least, most};
}

Interval extremes(const std::vector<Dataset>& datasets, std::vector<double> Dataset::*of) {
  Interval all = extremes(datasets.front().*of);
  for (const Dataset& dataset : datasets) {
    const Interval one = extremes(dataset.*of);
    all = {std::min(all.lo, one.lo), std::max(all.hi, one.hi)};
  }
  return all;
}

Dataset in_um(Dataset dataset, const std::filesystem::path& file) {
  const auto um = model::length_um(dataset.output_unit);
  if (!um)
    throw Error(
        fmt::format("{}: the output is in {}, expected a length: --output-scale says how many um one {} is",
                    file.string(), dataset.output_unit, dataset.output_unit));
  for (double& value : dataset.output) value *= *um;
  dataset.output_unit = "um";
  return dataset;
}

void refuse_drive(const std::filesystem::path& file, const Dataset& dataset, const AxisFacts& axis) {
  const Interval drive = extremes(dataset.input);
  const double slack = 1e-3 * (axis.drive_max - axis.drive_min);
  if (drive.lo < axis.drive_min - slack || drive.hi > axis.drive_max + slack)
    throw Error(
        fmt::format("{}: the drive goes from {:.6g} to {:.6g} {}, beyond --drive-min {:g} and "
                    "--drive-max {:g}, expected a record within them",
                    file.string(), drive.lo, drive.hi, axis.drive_unit, axis.drive_min, axis.drive_max));
  if (dataset.input_unit != axis.drive_unit)
    throw Error(fmt::format("{}: the drive is in {}, expected {}", file.string(), dataset.input_unit,
                            axis.drive_unit));
}

}  // namespace

Interval AxisRecords::drive() const { return extremes(loops, &Dataset::input); }
Interval AxisRecords::travel_um() const { return extremes(loops, &Dataset::output); }

std::vector<std::string> AxisRecords::names() const {
  std::vector<std::string> names;
  for (const auto& file : files.loops) names.push_back(file.filename().string());
  return names;
}

AxisRecords load_records(const RecordFiles& files, const DatasetInput& input) {
  AxisRecords records{.files = files, .loops = load_datasets(files.loops, input), .step = {}, .unseen = {}};
  for (std::size_t i = 0; i < records.loops.size(); ++i)
    records.loops[i] = in_um(std::move(records.loops[i]), files.loops[i]);
  if (files.step) records.step = in_um(load_datasets({*files.step}, input).front(), *files.step);
  if (files.unseen) records.unseen = in_um(load_datasets({*files.unseen}, input).front(), *files.unseen);
  return records;
}

void refuse_contradictions(const AxisRecords& records, const AxisFacts& axis,
                           std::optional<double> stroke_um) {
  for (std::size_t i = 0; i < records.loops.size(); ++i)
    refuse_drive(records.files.loops[i], records.loops[i], axis);
  if (records.step) refuse_drive(*records.files.step, *records.step, axis);
  if (records.unseen) refuse_drive(*records.files.unseen, *records.unseen, axis);
  if (!stroke_um) return;
  const double part = records.drive().span() / (axis.drive_max - axis.drive_min);
  // A record over the whole range shows the stroke. Minor loops are flatter than the major one, and curves bend.
  const double tolerance = part > 0.95 ? 0.1 : 0.5;
  const double expected_um = *stroke_um * part;
  if (std::abs(records.travel_um().span() / expected_um - 1.0) > tolerance)
    throw Error(fmt::format(
        "{}: the position moves by {:.4g} um where --stroke {:g} and its drive make {:.4g} um "
        "likely, expected about that: is the unit right? (--output-scale)",
        records.files.loops.front().string(), records.travel_um().span(), *stroke_um, expected_um));
}

}  // namespace hystcan::app
