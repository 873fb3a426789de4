#include "app/stage/identification_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/output_file.h"

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

void write_file(const std::filesystem::path& path, const std::string& text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
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

// An empty line between the rows of the map, as gnuplot wants it.
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

}  // namespace

std::size_t samples_per_row(const std::vector<Dataset>& datasets) {
  std::size_t samples = 0;
  for (const Dataset& dataset : datasets) samples += dataset.size();
  return std::max<std::size_t>(1, (samples + most_plotted - 1) / most_plotted);
}

void write_numbers(const std::filesystem::path& directory, const std::vector<Dataset>& datasets,
                   const Identified& identified, const Comparison& comparison,
                   const std::optional<Landscape>& landscape) {
  write_file(directory / "record.csv", record_rows(datasets, identified));
  write_file(directory / "curves.csv", curve_rows(identified));
  write_file(directory / "comparison.csv", comparison_rows(comparison));
  if (landscape) write_file(directory / "landscape.csv", landscape_rows(*landscape, identified));
}

}  // namespace hystcan::app
