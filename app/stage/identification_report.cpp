#include "app/stage/identification_report.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <system_error>

#include "app/live/stop_signal.h"
#include "app/stage/new_folder.h"
#include "app/stage/pictures.h"
#include "base/error.h"
#include "base/output_file.h"
#include "config/schema/config.h"
#include "identification/determination.h"

namespace hystcan::app {
namespace {

using identification::Comparison;
using identification::Dataset;
using identification::Identified;
using identification::Landscape;

std::string unit_lines(const Identified& identified) {
  std::string lines;
  const auto add = [&](const char* key, const std::string& unit) {
    if (!unit.empty()) lines += fmt::format("# {} = {}\n", key, unit);
  };
  add("input_unit", identified.parameters.input_unit);
  add("output_unit", identified.parameters.output_unit);
  return lines;
}

std::string record_rows(const std::vector<Dataset>& datasets, const Identified& identified) {
  const std::size_t stride = samples_per_row(datasets);
  std::string rows = unit_lines(identified) + "time_s,input,output,predicted,residual,record\n";
  for (std::size_t r = 0; r < datasets.size(); ++r) {
    const Dataset& dataset = datasets[r];
    const auto predicted = identification::predict(identified, datasets, r);
    const auto miss = [&](std::size_t i) { return std::abs(dataset.output[i] - predicted[i]); };
    for (std::size_t begin = 0; begin < dataset.size(); begin += stride) {
      std::size_t i = begin;
      for (std::size_t j = begin; j < std::min(begin + stride, dataset.size()); ++j)
        if (miss(j) > miss(i)) i = j;
      rows += fmt::format("{:.12g},{:.9g},{:.9g},{:.9g},{:.6g},{}\n", dataset.time_s[i], dataset.input[i],
                          dataset.output[i], predicted[i], dataset.output[i] - predicted[i], r + 1);
    }
  }
  return rows;
}

std::string curve_rows(const Identified& identified) {
  constexpr int points = 400;
  const model::HysteresisParameters& p = identified.parameters;
  std::string rows = unit_lines(identified) + "input,ascending,descending\n";
  for (int i = 0; i <= points; ++i) {
    const double v = p.input_range().lo + p.input_range().span() * i / points;
    rows += fmt::format("{:.9g},{:.9g},{:.9g}\n", v, p.output(p.ascending.value(v)),
                        p.output(p.descending.value(v)));
  }
  return rows;
}

// Returns the rows of landscape.csv: RMS errors for pairs of convergence rates (k_ascending, k_descending).
// The plot needs an empty line where k_descending changes.
std::string landscape_rows(const Landscape& map, const Identified& identified) {
  std::string rows = unit_lines(identified) + "k_ascending,k_descending,rms\n";
  for (std::size_t i = 0; i < map.k_descending.size(); ++i) {
    for (std::size_t j = 0; j < map.k_ascending.size(); ++j)
      rows += fmt::format("{:.9g},{:.9g},{:.6g}\n", map.k_ascending[j], map.k_descending[i], map.rms[i][j]);
    if (i + 1 < map.k_descending.size()) rows += "\n";
  }
  return rows;
}

std::string comparison_rows(const Comparison& comparison) {
  std::string rows =
      "model,parameters,fit_rms_percent,fit_max_percent,held_out_rms_percent,held_out_max_percent\n";
  const auto percent = [&](double error) { return 100.0 * error / comparison.output_span; };
  for (const auto& row : comparison.rows) {
    rows += fmt::format("\"{}\",{},{:.6g},{:.6g},", row.name, row.parameters, percent(row.fit.rms),
                        percent(row.fit.max));
    rows += row.held_out
                ? fmt::format("{:.6g},{:.6g}\n", percent(row.held_out->rms), percent(row.held_out->max))
                : ",\n";
  }
  return rows;
}

void write_numbers(const std::filesystem::path& directory, const std::vector<Dataset>& datasets,
                   const Identified& identified, const Comparison& comparison,
                   const std::optional<Landscape>& landscape) {
  write_file(directory / "record.csv", record_rows(datasets, identified));
  write_file(directory / "curves.csv", curve_rows(identified));
  write_file(directory / "comparison.csv", comparison_rows(comparison));
  if (landscape) write_file(directory / "landscape.csv", landscape_rows(*landscape, identified));
}

/// Draws all pictures of the report for which there are data. Returns the reason if a picture was not drawn.
std::optional<std::string> draw_report(const std::filesystem::path& directory, std::size_t datasets,
                                       const Identified& identified, bool has_landscape) {
  const model::HysteresisParameters& p = identified.parameters;
  const nlohmann::json input{{"input_unit", p.input_unit}}, output{{"output_unit", p.output_unit}},
      span{{"span", identified.output_span}};
  std::vector<Picture> all;
  const auto add = [&](const char* name, const char* kind, std::vector<std::string> data, double height_mm,
                       const std::vector<nlohmann::json>& facts) {
    all.push_back({.kind = kind,
                   .data = std::move(data),
                   .to = {fmt::format("{}.svg", name)},
                   .size = {.width_mm = 200.0, .height_mm = height_mm}});
    for (const nlohmann::json& fact : facts) all.back().facts.update(fact);
  };
  add("loops", "fit", {"record.csv"}, 140.0, {input, output});
  add("residual_time", "residual_time", {"record.csv"}, std::max(80.0, 68.0 * static_cast<double>(datasets)),
      {span});
  add("residual_input", "residual_input", {"record.csv"}, 100.0, {input, span});
  add("curves", "curves", {"record.csv", "curves.csv"}, 180.0,
      {input, output, span, {{"observed", {identified.observed.lo, identified.observed.hi}}}});
  if (has_landscape)
    add("landscape", "landscape", {"landscape.csv"}, 150.0,
        {span, {{"drive_span", p.input_range().span()}, {"best", {p.k_ascending, p.k_descending}}}});
  return draw_pictures(directory / "pictures.json", all);
}

constexpr int landscape_points = 21;

/// Moves the files of the new report to the folder `to`. Removes files of an earlier report that the new
/// report does not contain.
void move_files(const std::filesystem::path& from, const std::filesystem::path& to) {
  for (const std::string& name : report_files()) {
    std::error_code error;
    if (std::filesystem::exists(from / name))
      std::filesystem::rename(from / name, to / name, error);
    else
      std::filesystem::remove(to / name, error);
    if (error) throw RunError(to / name, fmt::format("cannot be replaced: {}", error.message()));
  }
}

}  // namespace

std::size_t samples_per_row(const std::vector<Dataset>& datasets) {
  std::size_t samples = 0;
  for (const Dataset& dataset : datasets) samples += dataset.size();
  return std::max<std::size_t>(1, (samples + most_plotted - 1) / most_plotted);
}

const std::vector<ReportPicture>& report_pictures() {
  static const std::vector<ReportPicture> all{
      {"loops", "Loops",
       "Measured and modelled output over the input. "
       "If the model is correct, its line is within the width of the measured line."},
      {"residual_time", "Residual over time",
       "The part of the output that the model does not explain. A slope is drift or creep; "
       "a residual that grows or shrinks at the beginning comes from a wrong initial memory."},
      {"residual_input", "Residual over input",
       "The residual for rising and for falling input. "
       "A wave in both directions shows that the order of the curves is too low. "
       "A gap between the two directions shows a delay or a dependence on the rate. "
       "A residual that spreads towards one end of the inputs shows a wrong threshold."},
      {"curves", "Reference curves",
       "The two curves from which the model computes all branches, and the distance between these curves. "
       "The inputs go from one threshold to the other. "
       "Beyond the observed inputs, the curves are extrapolated."},
      {"landscape", "Landscape of k",
       "RMS error of the best curves for each pair of k_ascending and k_descending. "
       "All other parameters have their identified values. "
       "A long valley means that many values of k fit equally well: the dataset does not determine k."}};
  return all;
}

const std::vector<std::string>& report_files() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all{"report.html",   "record.csv",     "curves.csv",
                                 "landscape.csv", "comparison.csv", "pictures.json"};
    for (const ReportPicture& picture : report_pictures()) all.push_back(picture.name + ".svg");
    return all;
  }();
  return names;
}

std::optional<std::string> write_report(const std::filesystem::path& directory, IdentificationReport report) {
  Progress progress("comparing models", 0, "trials");
  const std::function<bool()> go_on = counted_trials(progress);
  create_folder(directory);
  report.comparison = identification::compare(report.datasets, report.identified, go_on);
  std::optional<identification::Landscape> map;
  if (go_on()) map = identification::landscape(report.datasets, report.identified, landscape_points);
  // A temporary folder, so that an earlier report stays until the new one is complete.
  const NewFolder whole(directory / "report.new");
  write_numbers(whole.path(), report.datasets, report.identified, report.comparison, map);
  report.undrawn = draw_report(whole.path(), report.datasets.size(), report.identified, map.has_value());
  write_file(whole.path() / "report.html", page_of(whole.path(), report));
  move_files(whole.path(), directory);
  return report.undrawn;
}

}  // namespace hystcan::app
