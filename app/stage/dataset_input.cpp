#include "app/stage/dataset_input.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/stage/option_check.h"
#include "base/error.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "can/dbc/text.h"
#include "config/files/dataset_file.h"
#include "config/schema/config.h"
#include "controller/control/axis.h"
#include "model/any_model.h"
#include "runs/cycle_reader.h"
#include "runs/export.h"
#include "runs/run.h"

namespace hystcan::app {
namespace {

using identification::Dataset;

const std::vector<std::string> columns_of_a_run{"cycle", "time_s",      "state",
                                                "drive", "position_um", "sample_missing"};

struct Cycle {
  Cycle(std::span<const std::vector<double>> block, std::size_t row)
      : number(block[0][row]),
        time_s(block[1][row]),
        is_driven(controller::is_in_use(static_cast<controller::AxisState>(block[2][row]))),
        initialises(block[2][row] == static_cast<double>(controller::AxisState::initialising)),
        drive(block[3][row]),
        position_um(block[4][row]),
        sample_missing(block[5][row] != 0.0) {}

  double number, time_s;
  bool is_driven, initialises;
  double drive, position_um;
  bool sample_missing;
};

/// Finds the longest driven stretch of an axis. Its cycles must be added in order of time.
class LongestStretch {
 public:
  explicit LongestStretch(std::string name) : name_(std::move(name)) {}

  void add(const Cycle& cycle) {
    const std::optional<Cycle> before = std::exchange(before_, cycle);
    if (!before || !before->is_driven || !cycle.is_driven || before->number + 1.0 != cycle.number)
      return end_stretch();
    // True in the second cycle of a stretch. The row of a cycle contains the drive of the cycle before it.
    // Here this is the first cycle of the stretch; after arming, its drive is still the safe drive. The row
    // is therefore left out.
    const bool follows_arming = transitions_++ == 0;
    const bool may_be_disabled = present_.size() == 0 && cycle.initialises && cycle.drive == before->drive;
    if (follows_arming || may_be_disabled) return;
    if (cycle.sample_missing)
      ++present_missing_;
    else
      append(cycle.time_s, before->drive, cycle.position_um);
  }

  void end_stretch() {
    if (present_.size() > 0) ++stretches_;
    if (present_.size() > longest_.size()) {
      std::swap(longest_, present_);
      missing_ = present_missing_;
    }
    present_ = {};
    present_missing_ = transitions_ = 0;
  }

  Dataset take() { return std::move(longest_); }

  std::string text() const {
    std::string text = fmt::format("{} from {:.10g} s to {:.10g} s", counted(longest_.size(), "row"),
                                   longest_.time_s.front(), longest_.time_s.back());
    if (stretches_ > 1) text += fmt::format(", the longest of {} driven stretches", stretches_);
    if (missing_ > 0) text += fmt::format(", without {} that have no sample", counted(missing_, "cycle"));
    return text;
  }
  bool is_empty() const { return longest_.size() == 0; }

 private:
  void append(double time_s, double drive, double position_um) {
    if (present_.size() == config::most_dataset_rows)
      throw Error(name_, fmt::format("the axis is driven for more than {} rows", config::most_dataset_rows),
                  {.remedy = "select a part of the rows with --from and --to"});
    for (const double value : {time_s, drive, position_um})
      if (!(std::abs(value) <= identification::largest_value))
        throw Error(name_, fmt::format("a value is {} in cycle {}", value, before_->number),
                    expect("at most {} in magnitude", identification::largest_value));
    if (present_.size() > 0 && !(time_s > present_.time_s.back()))
      throw Error(name_, fmt::format("time_s is {} after {}", time_s, present_.time_s.back()),
                  expect("an increasing time"));
    present_.time_s.push_back(time_s);
    present_.input.push_back(drive);
    present_.output.push_back(position_um);
  }

  std::string name_;
  std::optional<Cycle> before_;
  Dataset present_, longest_;
  std::size_t transitions_ = 0;  ///< pairs of consecutive driven cycles in the current stretch
  std::size_t present_missing_ = 0, missing_ = 0;
  std::size_t stretches_ = 0;
};

/// Returns true if the path is a recorded run: a folder, or a CSV file of control cycles. A CSV file with
/// other columns is a dataset.
bool is_recorded_run(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_directory(file, ignored) || runs::has_cycles(file);
}

/// How a unit is named in a dataset and on the command line, and its default.
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

void settle(std::string& unit, const std::string& stated_unit, const UnitOf& of,
            const std::filesystem::path& file) {
  if (!stated_unit.empty()) {
    require_unit(file, of.name, unit, stated_unit);
    unit = stated_unit;
  }
  if (unit.empty()) {
    unit = of.assumed;
    note("hystcan: {}: {} is missing, assuming {}\n", file.string(), of.option, of.assumed);
  }
  if (has_control_character(unit))
    throw Error(file,
                fmt::format("{} contains a control character", stated_unit.empty() ? of.name : of.option),
                expect("one line of text"));
  unit = can::dbc::to_utf8(unit);
}

/// Converts the output of a dataset to the unit of the model. Throws Error if one unit is a length and the
/// other is not.
void convert_output(Dataset& dataset, const std::string& unit, const std::filesystem::path& file) {
  const auto from_um = model::length_um(dataset.output_unit), to_um = model::length_um(unit);
  if (!from_um || !to_um)
    return require_unit(file, unit_of_output.name, dataset.output_unit, unit, ", the model's");
  if (*from_um != *to_um)
    for (double& value : dataset.output) value *= *from_um / *to_um;
  dataset.output_unit = unit;
}

Dataset load_csv(const std::filesystem::path& file, const DatasetInput& input) {
  Dataset dataset = load_noting(file, input.layout);
  keep_interval(dataset, span_of(input));
  if (dataset.size() == 0)
    throw Error(
        file,
        fmt::format("no rows{}", input.layout.from_s || input.layout.to_s ? " between --from and --to" : ""),
        expect("a dataset"));
  return dataset;
}

/// Loads a recorded run. Throws Error if the user gives options for columns, sampling rate or scale, because
/// a run defines these itself.
Dataset load_run(const std::filesystem::path& run, const DatasetInput& input) {
  const config::DatasetLayout& layout = input.layout;
  if (!layout.columns.empty() || layout.rate_Hz || layout.output_scale || !layout.output_from.empty())
    throw Error(run,
                "--columns, --rate, --output-scale and --output-from are not allowed with a recorded run");
  return app::load_run(run, input.axis, span_of(input));
}

Dataset load(const std::filesystem::path& file, const DatasetInput& input) {
  Dataset dataset = is_recorded_run(file) ? load_run(file, input) : load_csv(file, input);
  settle(dataset.input_unit, input.input_unit, unit_of_input, file);
  if (dataset.output_unit.empty() && input.output_unit.empty() && !input.model_output_unit.empty()) {
    dataset.output_unit = input.model_output_unit;
    if (input.model_output_unit != unit_of_output.assumed)
      note("hystcan: {}: the output has no unit, assuming {} as in the model\n", file.string(),
           input.model_output_unit);
  }
  settle(dataset.output_unit, input.output_unit, unit_of_output, file);
  if (!input.model_output_unit.empty()) convert_output(dataset, input.model_output_unit, file);
  return dataset;
}

}  // namespace

runs::Run open_run(const std::filesystem::path& file) {
  runs::Run run(file);
  for (const std::string& left_out : run.notes()) note("hystcan: {}\n", left_out);
  return run;
}

Dataset load_run(const std::filesystem::path& file, const std::string& axis, const runs::TimeSpan& span) {
  const runs::Run run = open_run(file);
  if (run.info().rows == 0) throw Error(file, "no rows", expect("a run"));
  const std::size_t index = runs::axis_of(run, axis.empty() ? std::nullopt : std::optional(axis));
  const runs::RunAxis& about = run.info().axes[index];
  LongestStretch stretch(file.string());
  run.read_blocks({&index, 1}, columns_of_a_run, span,
                  [&](std::size_t, std::span<const std::vector<double>> block) {
                    for (std::size_t row = 0; row < block.front().size(); ++row)
                      stretch.add(Cycle(block, row));
                  });
  stretch.end_stretch();
  if (stretch.is_empty())
    throw Error(file, fmt::format("axis {} is not driven in these cycles", about.name),
                expect("cycles between {:g} and {:g} s in which the axis is initialising, ready or tracking",
                       run.info().first_s, run.info().last_s));
  note("hystcan: {}: axis {}, {}\n", file.string(), about.name, stretch.text());
  Dataset dataset = stretch.take();
  dataset.input_unit = about.drive_unit;
  dataset.output_unit = "um";
  return dataset;
}

runs::TimeSpan span_of(const DatasetInput& input) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const runs::TimeSpan span{input.layout.from_s.value_or(-infinity), input.layout.to_s.value_or(infinity)};
  if (span.from_s > span.to_s)
    throw Error(fmt::format("--from is {}", span.from_s), expect("at most --to, {}", span.to_s));
  return span;
}

void require_run_for_axis(const std::vector<std::filesystem::path>& files, const DatasetInput& input,
                          const char* otherwise) {
  if (!input.axis.empty() && std::ranges::none_of(files, is_recorded_run))
    throw Error(fmt::format("--axis is {}", input.axis), expect("a recorded run{}", otherwise));
}

Dataset load_noting(const std::filesystem::path& file, const config::DatasetLayout& layout) {
  config::DatasetFile loaded = config::load_dataset(file, layout);
  if (!loaded.taken.empty())
    note("hystcan: {}: {} (--columns selects other columns)\n", file.string(), loaded.taken);
  for (const std::string& note_text : loaded.notes) note("hystcan: {}: {}\n", file.string(), note_text);
  return std::move(loaded.dataset);
}

void require_unit(const std::filesystem::path& file, const char* name, const std::string& file_unit,
                  const std::string& expected, const char* suffix) {
  if (!file_unit.empty() && file_unit != expected)
    throw Error(file, fmt::format("the file has {} = \"{}\"", name, file_unit),
                expect("\"{}\"{}", expected, suffix));
}

void add_column_options(CLI::App& command, config::DatasetLayout& layout) {
  command.add_option(
      "--columns", layout.columns,
      "columns of time, input and output, by name or number (example: t,V,x); default: detected");
  command.add_option("--output-from", layout.output_from,
                     "file of the output, if each channel has its own file");
  add_checked(command, "--output-scale", layout.output_scale, finite_number(),
              "scale of an output column that is not a length, um per unit (12.5 for a sensor of 12.5 um/V)");
}

void add_layout_options(CLI::App& command, DatasetInput& input) {
  add_column_options(command, input.layout);
  add_checked(command, "--rate", input.layout.rate_Hz, positive_number(),
              "sampling rate in Hz, if the time is missing or is a sample number");
}

void add_interval_options(CLI::App& command, DatasetInput& input) {
  add_checked(command, "--from", input.layout.from_s, finite_number(),
              "first time_s; earlier rows are left out");
  add_checked(command, "--to", input.layout.to_s, finite_number(), "last time_s; later rows are left out");
  input.layout.has_interval_options = true;
}

void add_dataset_options(CLI::App& command, DatasetInput& input) {
  add_layout_options(command, input);
  add_interval_options(command, input);
  command.add_option(unit_of_input.option, input.input_unit,
                     "unit of the input, for example A, if the file does not state it; default: V");
  command.add_option(
      unit_of_output.option, input.output_unit,
      "unit of the output, if the file does not state it; default: the unit of the model, or um");
}

std::vector<Dataset> load_datasets(const std::vector<std::filesystem::path>& files,
                                   const DatasetInput& input) {
  span_of(input);
  if (files.size() > 1 && !input.layout.output_from.empty())
    throw Error(fmt::format("--output-from is {}", input.layout.output_from.string()),
                expect("one input file, not {}", files.size()));
  std::vector<Dataset> datasets;
  for (const auto& file : files) {
    datasets.push_back(load(file, input));
    const Dataset &first = datasets.front(), &last = datasets.back();
    if (last.input_unit != first.input_unit || last.output_unit != first.output_unit)
      throw Error(file, fmt::format("the units are {} and {}", last.input_unit, last.output_unit),
                  expect("{} and {} as in {}", first.input_unit, first.output_unit, files.front().string()));
  }
  return datasets;
}

}  // namespace hystcan::app
