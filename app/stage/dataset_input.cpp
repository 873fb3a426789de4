#include "app/stage/dataset_input.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <limits>

#include "app/stage/option_check.h"
#include "app/stage/run_dataset.h"
#include "base/standard_streams.h"
#include "config/files/dataset_file.h"
#include "config/schema/config.h"

namespace hystcan::app {
namespace {

using identification::Dataset;

/// The name of a unit in a dataset, its option on the command line, and its default.
struct UnitOf {
  const char* name;
  const char* option;
  const char* assumed;
};
constexpr UnitOf unit_of_input{"input_unit", "--input-unit", "V"};
constexpr UnitOf unit_of_output{"output_unit", "--output-unit", "um"};

void keep_interval(Dataset& dataset, const runs::TimeSpan& span) {
  const auto first = std::ranges::lower_bound(dataset.time_s, span.from_s);
  const auto last = std::ranges::upper_bound(dataset.time_s, span.to_s);
  const auto begin = first - dataset.time_s.begin(), end = std::max(last, first) - dataset.time_s.begin();
  for (auto* column : {&dataset.time_s, &dataset.input, &dataset.output}) {
    column->erase(column->begin() + end, column->end());
    column->erase(column->begin(), column->begin() + begin);
  }
}

void settle(std::string& unit, const std::string& asked, const UnitOf& of,
            const std::filesystem::path& file) {
  if (!asked.empty()) {
    require_unit(file, of.name, unit, asked);
    unit = asked;
  }
  if (unit.empty()) {
    unit = of.assumed;
    note("hystcan: {}: {} is not given, {} assumed\n", file.string(), of.option, of.assumed);
  }
}

Dataset load_csv(const std::filesystem::path& file, const DatasetInput& input) {
  Dataset dataset = load_noting(file, input.layout);
  keep_interval(dataset, span_of(input));
  if (dataset.size() == 0)
    throw Error(fmt::format("{}: no rows{}, expected a dataset", file.string(),
                            input.from_s || input.to_s ? " between --from and --to" : ""));
  return dataset;
}

Dataset load(const std::filesystem::path& file, const DatasetInput& input) {
  Dataset dataset =
      is_recorded_run(file) ? load_run(file, input.axis, span_of(input)) : load_csv(file, input);
  settle(dataset.input_unit, input.input_unit, unit_of_input, file);
  settle(dataset.output_unit, input.output_unit, unit_of_output, file);
  return dataset;
}

}  // namespace

runs::TimeSpan span_of(const DatasetInput& input) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const runs::TimeSpan span{input.from_s.value_or(-infinity), input.to_s.value_or(infinity)};
  if (span.from_s > span.to_s)
    throw Error(fmt::format("--from is {}, expected at most --to, {}", span.from_s, span.to_s));
  return span;
}

void require_run_for_axis(const std::vector<std::filesystem::path>& files, const DatasetInput& input,
                          const char* otherwise) {
  if (!input.axis.empty() && std::ranges::none_of(files, is_recorded_run))
    throw Error(fmt::format("--axis is {}, expected a recorded run{}", input.axis, otherwise));
}

Dataset load_noting(const std::filesystem::path& file, const config::DatasetLayout& layout) {
  config::DatasetFile loaded = config::load_dataset(file, layout);
  if (!loaded.taken.empty())
    note("hystcan: {}: {} (--columns says otherwise)\n", file.string(), loaded.taken);
  if (loaded.last_row_left_out)
    note("hystcan: {}: the last row has no line end and may be incomplete: left out\n", file.string());
  return std::move(loaded.dataset);
}

void require_unit(const std::filesystem::path& file, const char* name, const std::string& file_unit,
                  const std::string& expected, const char* suffix) {
  if (!file_unit.empty() && file_unit != expected)
    throw Error(fmt::format("{}: the file says {} = \"{}\", expected \"{}\"{}", file.string(), name,
                            file_unit, expected, suffix));
}

void add_column_options(CLI::App& command, config::DatasetLayout& layout) {
  command.add_option(
      "--columns", layout.columns,
      "the columns of time, input and output, by name or number: t,V,x; if left out, by likeness");
  command
      .add_option(
          "--output-scale", layout.output_scale,
          "um of one unit of the output column, where it is no length: 12.5 for a sensor of 12.5 um/V")
      ->check(finite_number());
}

void add_interval_options(CLI::App& command, DatasetInput& input) {
  add_column_options(command, input.layout);
  command
      .add_option("--rate", input.layout.rate_Hz,
                  "sampling rate in Hz, where there is no time or it is the number of the sample")
      ->check(positive_number());
  command.add_option("--from", input.from_s, "leave out the rows before this time_s")->check(finite_number());
  command.add_option("--to", input.to_s, "leave out the rows after this time_s")->check(finite_number());
}

void add_dataset_options(CLI::App& command, DatasetInput& input) {
  add_interval_options(command, input);
  command.add_option(unit_of_input.option, input.input_unit,
                     "unit of the input, if the file does not state it: V, A");
  command.add_option(unit_of_output.option, input.output_unit,
                     "unit of the output, if the file does not state it: um");
}

std::vector<Dataset> load_datasets(const std::vector<std::filesystem::path>& files,
                                   const DatasetInput& input) {
  span_of(input);
  std::vector<Dataset> datasets;
  for (const auto& file : files) {
    datasets.push_back(load(file, input));
    const Dataset &first = datasets.front(), &last = datasets.back();
    if (last.input_unit != first.input_unit || last.output_unit != first.output_unit)
      throw Error(fmt::format("{}: {} to {}, expected {} to {} as in {}", file.string(), last.input_unit,
                              last.output_unit, first.input_unit, first.output_unit, files.front().string()));
  }
  return datasets;
}

}  // namespace hystcan::app
