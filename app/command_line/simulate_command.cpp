#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "app/command_line/commands.h"
#include "app/command_line/pipeline.h"
#include "app/command_line/row_files.h"
#include "app/command_line/simulated_mode.h"
#include "app/live/stop_signal.h"
#include "app/stage/dataset_input.h"
#include "app/stage/identification_result.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "base/terminal.h"
#include "base/text.h"
#include "config/files/actuator.h"

namespace hystcan::app {
namespace {

struct SimulateArguments {
  std::filesystem::path model;
  std::filesystem::path input;
  std::filesystem::path output;
  std::filesystem::path memory;
  std::filesystem::path save_memory;
  bool inverse = false;
  bool negative_drive = false;
  bool beyond_limit = false;
  bool quasi_static = false;
  bool dynamics = false;
  bool overwrite = false;
};

/// Throws Error if a time is not later than the time of the row before, because creep needs a positive time
/// between rows. `before_s`: time of the last row before the block. `rows`: number of rows before the block.
void require_later_rows(const SimulateArguments& options, std::optional<double> before_s,
                        const SampleBlock& block, std::size_t rows) {
  for (const double time_s : block.time_s) {
    const bool is_later = !before_s || time_s > *before_s;
    if (!is_later && rows == 0)
      throw Error(options.input, fmt::format("the first row is at {} s", time_s),
                  {.expected = fmt::format("more than {} s, which is time_s of {}", *before_s,
                                           options.memory.string()),
                   .remedy = "remove time_s from the memory file, so that the first row can have any time"});
    if (!is_later)
      throw Error(options.input, fmt::format("row {} is at {} s", rows + 1, time_s),
                  expect("more than {} s, the time of the row before: "
                         "[creep] of the model needs a positive time between rows",
                         *before_s));
    before_s = time_s;
    ++rows;
  }
}

/// Simulates the input file in constant memory and writes the rows to `out`. Returns the number of all rows,
/// of the rows whose requested value was replaced by the nearest value that the model can reach, and of the
/// rows in which the model is on a branch that does not increase.
model::Tally run(const SimulateArguments& options, const config::Actuator& actuator,
                 config::ActuatorMemory& memory, RowOutput& out) {
  const std::unique_ptr<RowInput> rows = open_rows(options.input, options.inverse ? "output" : "input");
  require_unit(options.input, options.inverse ? "output_unit" : "input_unit", rows->unit(),
               options.inverse ? actuator.output_unit : actuator.input_unit, ", the model's");
  if (memory.creeps() && !rows->timed())
    throw Error(options.input, "has no column time_s",
                {.expected = fmt::format("this column, because {} has [creep]", options.model.string()),
                 .remedy = "use --quasi-static to ignore creep"});
  std::optional<SimulatedMode> mode;
  if (options.dynamics) mode.emplace(actuator, options.model, options.input);
  Progress progress("simulating", rows->size());
  std::uint64_t count = 0;
  model::Tally tally;
  run_pipeline<SampleBlock>(
      [&](SampleBlock& block) {
        if (stop_signalled != 0)
          throw RunError(fmt::format("stopped in row {}", count + 1), {.remedy = "nothing is written"});
        const bool is_one = rows->next(block);
        count += block.given.size();
        progress.update(rows->done(), count);
        return is_one;
      },
      [&](SampleBlock& block) {
        if (memory.creeps()) require_later_rows(options, memory.time_s(), block, tally.rows);
        config::Pass pass =
            options.inverse ? memory.inverse(block.given, block.time_s, options.negative_drive ? -1.0 : 1.0)
                            : memory.simulate(block.given, block.time_s);
        tally += pass.tally;
        block.input = options.inverse ? std::move(pass.inputs) : block.given;
        block.output = std::move(pass.outputs);
        if (mode) mode->move(block);
      },
      [&](const SampleBlock& block) { out.write(block); });
  for (const std::string& left_out : rows->notes())
    note("hystcan: {}: {}\n", options.input.string(), left_out);
  if (count == 0) throw Error(options.input, "has no rows", expect("at least one"));
  return tally;
}

void report_simulation(const SimulateArguments& options, const config::Actuator& actuator,
                       const config::ActuatorMemory& memory, const model::Tally& tally) {
  const model::Interval range = actuator.input_range();
  note("{}: {}, {} of them limited to the thresholds {} and {} {}\n", options.output.string(),
       counted(tally.rows, "row"), tally.saturated, range.lo, range.hi, actuator.input_unit);
  if (memory.creeps()) note("the outputs include {} of the model file\n", creep_text(*actuator.lag.creep));
  if (tally.not_increasing > 0)
    note("{} on a branch that does not increase, where the inverse of the model is not valid\n",
         counted(tally.not_increasing, "row"));
  if (memory.merged() > 0)
    note("in {} the memory of {} turning points was full, so the innermost loops were lost\n",
         counted(memory.merged(), "step"), config::ActuatorMemory::capacity);
}

void simulate(const SimulateArguments& options, const config::Actuator& actuator) {
  if (options.negative_drive && !actuator.is_even())
    throw Error(options.model, "symmetry is \"none\"", expect("\"even\" with --negative-drive"));
  config::ActuatorMemory memory = actuator.memory();
  if (options.quasi_static && !options.memory.empty())
    memory.load_hysteresis(options.memory);
  else if (!options.memory.empty())
    memory.load(options.memory);
  const auto out = make_rows(options.output, actuator.input_unit, actuator.output_unit);
  std::optional<OutputFile> saved;
  if (!options.save_memory.empty()) saved.emplace(options.save_memory);
  const model::Tally tally = run(options, actuator, memory, *out);
  out->commit();
  if (saved) saved->write(memory.text());
  if (saved) saved->commit();
  report_simulation(options, actuator, memory, tally);
}

int simulate(const SimulateArguments& options) {
  for (const auto& output : {options.output, options.save_memory})
    for (const auto& input : {options.model, options.input}) refuse_to_overwrite(output, input);
  refuse_to_overwrite(options.output, options.memory);
  refuse_to_replace(options.output, options.overwrite);
  // If --save-memory and --memory name the same file, --overwrite is not necessary: the memory is read from
  // this file and then saved to it. equivalent() fails if a file is missing; the files are then not the same.
  std::error_code ignored;
  if (!std::filesystem::equivalent(options.save_memory, options.memory, ignored))
    refuse_to_replace(options.save_memory, options.overwrite);
  if (!options.save_memory.empty()) refuse_to_share(options.output, options.save_memory);
  stop_at_a_signal();
  const config::Actuator actuator = config::Actuator::load(options.model, options.beyond_limit);
  simulate(options, options.quasi_static ? actuator.quasi_static() : actuator);
  return done;
}

}  // namespace

void add_simulate(CLI::App& cli, int& status) {
  auto options = std::make_shared<SimulateArguments>();
  CLI::App* command =
      cli.add_subcommand("simulate", "Run a hysteresis model, or its inverse, over a CSV file");
  command->add_option("MODEL", options->model, "model file (TOML), of any kind")->required();
  command
      ->add_option("--input", options->input,
                   "CSV or HDF5 file with a column `input` (with --inverse: `output`)")
      ->required();
  command
      ->add_option("--output", options->output,
                   "output file with time_s,input,output: HDF5 if its name ends in .h5, else CSV")
      ->required();
  command->add_flag("--overwrite", options->overwrite, "replace existing files");
  command->add_option("--memory", options->memory,
                      "initial memory (TOML); default: the ascending reference curve");
  command->add_option("--save-memory", options->save_memory,
                      "file for the final memory, from which another run can continue");
  CLI::Option* inverse =
      command->add_flag("--inverse", options->inverse, "compute the input that gives each output");
  CLI::Option* dynamics =
      command
          ->add_flag("--dynamics", options->dynamics,
                     "compute the position of the stage with [dynamics] of the model file")
          ->excludes(inverse);
  command->add_flag("--quasi-static", options->quasi_static, "ignore [creep] of the model file")
      ->excludes(dynamics);
  command
      ->add_flag("--negative-drive", options->negative_drive,
                 "choose the negative input (an even model has two inputs, v and -v, for each output)")
      ->needs(inverse);
  command
      ->add_flag("--beyond-limit", options->beyond_limit,
                 "accept a model with branches that do not increase, for study")
      ->excludes(inverse);
  command->callback([options, &status] { status = simulate(*options); });
}

}  // namespace hystcan::app
