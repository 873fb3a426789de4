#include "app/stage/stage_records.h"

#include <fmt/format.h>

#include <cmath>

#include <algorithm>
#include <string>

#include "app/stage/record_warnings.h"
#include "base/error.h"
#include "base/standard_streams.h"
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
    throw Error(file, fmt::format("the output is in {}", dataset.output_unit),
                expect("a length; set --output-scale to the number of um per {}", dataset.output_unit));
  for (double& value : dataset.output) value *= *um;
  dataset.output_unit = "um";
  return dataset;
}

void refuse_drive(const std::filesystem::path& file, const Dataset& dataset, const std::string& unit,
                  const Interval& allowed) {
  const Interval drive = extremes(dataset.input);
  const double slack = 1e-3 * allowed.span();
  if (drive.lo < allowed.lo - slack || drive.hi > allowed.hi + slack)
    throw Error(
        file,
        fmt::format("the drive ranges from {:.6g} to {:.6g} {}, beyond --drive-min {:g} and --drive-max {:g}",
                    drive.lo, drive.hi, unit, allowed.lo, allowed.hi),
        expect("a record within these limits"));
  if (dataset.input_unit != unit)
    throw Error(file, fmt::format("the drive is in {}", dataset.input_unit), {.expected = unit});
}

/// Finds doubtful data in a record: drop-outs, glitches and a saturated sensor. If `accept` is false, throws
/// Error for such data, because the limits of the stage are derived from its records. Otherwise, prints a
/// warning for each kind, and removes drop-outs and glitches.
void judge_record(const std::filesystem::path& file, Dataset& dataset, bool accept) {
  for (const RecordWarning& warning : leave_out_suspects(file, dataset)) {
    if (!accept)
      throw Error(warning.fact + ", and the record sets the limits of the stage",
                  {.remedy = "record the dataset again, or add --accept"});
    note("hystcan: {}\n", warning.text());
  }
}

void judge_records(AxisRecords& records, bool accept) {
  refuse_same_rows(records.loop_files, records.loops);
  for (std::size_t i = 0; records.unseen && i < records.loops.size(); ++i)
    refuse_same_rows(*records.unseen_file, *records.unseen, records.loop_files[i], records.loops[i]);
  for (std::size_t i = 0; i < records.loops.size(); ++i)
    judge_record(records.loop_files[i], records.loops[i], accept);
  if (records.step) judge_record(*records.step_file, *records.step, accept);
  if (records.unseen) judge_record(*records.unseen_file, *records.unseen, accept);
}

}  // namespace

Interval AxisRecords::drive() const { return extremes(loops, &Dataset::input); }
Interval AxisRecords::travel_um() const { return extremes(loops, &Dataset::output); }

std::vector<std::string> AxisRecords::names() const {
  std::vector<std::string> names;
  for (const auto& file : loop_files) names.push_back(file.filename().string());
  return names;
}

void load(AxisRecords& records, const DatasetInput& input, bool accept) {
  if (!input.layout.output_from.empty() &&
      records.loop_files.size() + records.step_file.has_value() + records.unseen_file.has_value() > 1)
    throw Error(fmt::format("--output-from {} is not allowed with more than one record",
                            input.layout.output_from.string()),
                {.remedy = "write time, input and output of each record into one file"});
  records.loops = load_datasets(records.loop_files, input);
  for (std::size_t i = 0; i < records.loops.size(); ++i)
    records.loops[i] = in_um(std::move(records.loops[i]), records.loop_files[i]);
  const auto load_one = [&](const std::filesystem::path& file) {
    return in_um(load_datasets({file}, input).front(), file);
  };
  if (records.step_file) records.step = load_one(*records.step_file);
  if (records.unseen_file) records.unseen = load_one(*records.unseen_file);
  judge_records(records, accept);
}

void refuse_contradictions(const AxisRecords& records, const std::string& drive_unit, const Interval& drive,
                           std::optional<double> stroke_um) {
  for (std::size_t i = 0; i < records.loops.size(); ++i)
    refuse_drive(records.loop_files[i], records.loops[i], drive_unit, drive);
  if (records.step) refuse_drive(*records.step_file, *records.step, drive_unit, drive);
  if (records.unseen) refuse_drive(*records.unseen_file, *records.unseen, drive_unit, drive);
  if (!stroke_um) return;
  const double part = records.drive().span() / drive.span();
  // A record over a part of the drive range gets a larger tolerance. Its travel is not exactly this part of
  // the stroke: the slope of a smaller loop is lower, and hysteresis curves are not straight.
  const double tolerance = part > 0.95 ? 0.1 : 0.5;
  const double expected_um = *stroke_um * part;
  if (std::abs(records.travel_um().span() / expected_um - 1.0) > tolerance)
    throw Error(
        records.loop_files.front(),
        fmt::format("the position moves by {:.4g} um, but --stroke {:g} and the drive suggest {:.4g} um",
                    records.travel_um().span(), *stroke_um, expected_um),
        {.remedy = "check the unit of the output (--output-scale) and --stroke"});
}

}  // namespace hystcan::app
