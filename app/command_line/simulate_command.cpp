#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <variant>
#include <vector>

#include "app/command_line/commands.h"
#include "app/command_line/pipeline.h"
#include "app/command_line/row_files.h"
#include "app/command_line/simulated_stage.h"
#include "app/live/stop_signal.h"
#include "app/stage/dataset_input.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "base/terminal.h"
#include "base/text.h"
#include "config/files/memory_file.h"
#include "config/files/model_file.h"
#include "model/hysteresis_operator.h"

namespace hystcan::app {
namespace {

constexpr std::size_t capacity = 4096;

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

model::AnyModel load(const SimulateArguments& options) {
  if (options.beyond_limit) return config::load_model_beyond_limit(options.model);
  return config::load_any_model(options.model);
}

template <class Model>
model::HysteresisState at_rest(const Model& model) {
  return model.virgin(model.input_range().lo, capacity);
}
model::PlayState at_rest(const model::PrandtlIshlinskii& model) {
  return model.virgin(model.input_range().lo);
}

template <class Model>
bool is_even(const Model& model) {
  return model.symmetry() == model::Symmetry::even;
}
bool is_even(const model::PrandtlIshlinskii&) { return false; }

template <class Model>
typename Model::State start(const SimulateArguments& options, const Model& model) {
  return options.memory.empty() ? at_rest(model) : config::load_memory(options.memory, model, capacity);
}

template <class Model>
model::Row follow(model::Simulation<Model>& simulation, bool inverse, double given) {
  return inverse ? simulation.follow_output(given) : simulation.follow_input(given);
}

template <class Model>
model::Row follow(model::Simulation<Model>& simulation, SimulatedCreep& creep, bool inverse, double time_s,
                  double given) {
  creep.hold_until(time_s);
  model::Row row = follow(simulation, inverse, inverse ? creep.inverse(given) : given);
  row.output = creep.follow(row.output);
  return row;
}

template <class Model>
void compute(model::Simulation<Model>& simulation, std::optional<SimulatedCreep>& creep, bool inverse,
             SampleBlock& block) {
  block.input.resize(block.given.size());
  block.output.resize(block.given.size());
  for (std::size_t i = 0; i < block.given.size(); ++i) {
    const model::Row row = creep ? follow(simulation, *creep, inverse, block.time_s[i], block.given[i])
                                 : follow(simulation, inverse, block.given[i]);
    block.input[i] = row.input;
    block.output[i] = row.output;
  }
}

/// In constant memory. Returns the creep after the last row, if there is one.
template <class Model>
std::optional<SimulatedCreep> run(const SimulateArguments& options, model::Simulation<Model>& simulation,
                                  RowOutput& out) {
  const std::unique_ptr<RowInput> rows = open_rows(options.input, options.inverse ? "output" : "input");
  const auto& parameters = simulation.model().parameters();
  require_unit(options.input, options.inverse ? "output_unit" : "input_unit", rows->unit(),
               options.inverse ? parameters.output_unit : parameters.input_unit, ", the model's");
  Progress progress("simulating", rows->size());
  std::uint64_t count = 0;
  std::optional<SimulatedCreep> creep;
  if (!options.quasi_static)
    creep =
        SimulatedCreep::load(options.model, options.input, options.memory, simulation.state().output, *rows);
  std::optional<SimulatedMode> mode;
  if (options.dynamics) mode.emplace(options.model, options.input);
  run_pipeline<SampleBlock>(
      [&](SampleBlock& block) {
        if (stop_signalled != 0)
          throw RunError(fmt::format("stopped in row {}; nothing is written", count + 1));
        const bool is_one = rows->next(block);
        count += block.given.size();
        progress.update(rows->done(), count);
        return is_one;
      },
      [&](SampleBlock& block) {
        compute(simulation, creep, options.inverse, block);
        if (mode) mode->move(block);
      },
      [&](const SampleBlock& block) { out.write(block); });
  for (const std::string& left_out : rows->notes())
    note("hystcan: {}: {}\n", options.input.string(), left_out);
  if (count == 0) throw Error(fmt::format("{}: has no rows, expected at least one", options.input.string()));
  return creep;
}

template <class Model>
void save(OutputFile& out, const model::Simulation<Model>& simulation,
          const std::optional<SimulatedCreep>& creep) {
  out.write(config::memory_text(simulation.model(), simulation.state()));
  if (creep) out.write(creep->memory_text());
  out.commit();
}

template <class Model>
void report_simulation(const SimulateArguments& options, const model::Simulation<Model>& simulation,
                       const std::optional<SimulatedCreep>& creep) {
  const model::Tally& tally = simulation.tally();
  const model::Interval& range = simulation.model().input_range();
  note("{}: {}, {} of them limited to the thresholds {} and {} {}\n", options.output.string(),
       counted(tally.rows, "row"), tally.saturated, range.lo, range.hi,
       simulation.model().parameters().input_unit);
  if (creep) note("with {}, of the model file\n", creep->text());
  if (tally.not_increasing > 0)
    note("{} on a branch that is not increasing: its inverse is not valid there\n",
         counted(tally.not_increasing, "row"));
  if constexpr (requires { simulation.state().merged; })
    if (simulation.state().merged > 0)
      note("{} with a full memory of {} turning points: the innermost loops are lost\n",
           counted(simulation.state().merged, "step"), capacity);
}

template <class Model>
void simulate(const SimulateArguments& options, const Model& model) {
  if (options.negative_drive && !is_even(model))
    throw Error(fmt::format("{}: symmetry is \"none\", expected \"even\" with --negative-drive",
                            options.model.string()));
  model::Simulation<Model> simulation(model, start(options, model), options.negative_drive ? -1.0 : 1.0);
  const auto& parameters = model.parameters();
  const auto out = make_rows(options.output, parameters.input_unit, parameters.output_unit);
  std::optional<OutputFile> memory;
  if (!options.save_memory.empty()) memory.emplace(options.save_memory);
  const std::optional<SimulatedCreep> creep = run(options, simulation, *out);
  out->commit();
  if (memory) save(*memory, simulation, creep);
  report_simulation(options, simulation, creep);
}

int simulate(const SimulateArguments& options) {
  for (const auto& output : {options.output, options.save_memory})
    for (const auto& input : {options.model, options.input}) refuse_to_overwrite(output, input);
  refuse_to_overwrite(options.output, options.memory);
  refuse_to_replace(options.output, options.overwrite);
  std::error_code ignored;  // a memory may go on in its own file
  if (!std::filesystem::equivalent(options.save_memory, options.memory, ignored))
    refuse_to_replace(options.save_memory, options.overwrite);
  if (!options.save_memory.empty()) refuse_to_share(options.output, options.save_memory);
  stop_at_a_signal();
  std::visit([&](const auto& model) { simulate(options, model); }, load(options));
  return done;
}

}  // namespace

void add_simulate(CLI::App& cli, int& status) {
  auto options = std::make_shared<SimulateArguments>();
  CLI::App* command =
      cli.add_subcommand("simulate", "Run a hysteresis model, or its inverse, over a CSV file");
  command->add_option("MODEL", options->model, "model file (TOML), of any kind")->required();
  command
      ->add_option("--input", options->input, "CSV or HDF5 with a column `input` (with --inverse: `output`)")
      ->required();
  command
      ->add_option("--output", options->output,
                   "file to write: time_s,input,output; HDF5 if its name ends in .h5, else CSV")
      ->required();
  command->add_flag("--overwrite", options->overwrite, "replace files to write that exist");
  command->add_option("--memory", options->memory,
                      "start from this memory (TOML) instead of the ascending reference curve");
  command->add_option("--save-memory", options->save_memory,
                      "write the final memory, from which a next run can continue");
  CLI::Option* inverse =
      command->add_flag("--inverse", options->inverse, "compute the input that gives each output");
  CLI::Option* dynamics = command
                              ->add_flag("--dynamics", options->dynamics,
                                         "the position of the stage, with [dynamics] of the model file")
                              ->excludes(inverse);
  command
      ->add_flag("--quasi-static", options->quasi_static,
                 "the hysteresis alone, without [creep] of the model file")
      ->excludes(dynamics);
  command
      ->add_flag("--negative-drive", options->negative_drive,
                 "use the negative one of the two inputs of an even model")
      ->needs(inverse);
  command
      ->add_flag("--beyond-limit", options->beyond_limit,
                 "accept a model whose branches do not all increase, for study")
      ->excludes(inverse);
  command->callback([options, &status] { status = simulate(*options); });
}

}  // namespace hystcan::app
