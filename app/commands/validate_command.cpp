#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "app/commands/commands.h"
#include "app/io/dataset_input.h"
#include "app/io/option_check.h"
#include "app/io/output_file.h"
#include "app/io/standard_streams.h"
#include "app/live/stop_signal.h"
#include "can/counted.h"
#include "config/files/model_file.h"
#include "config/schema/config.h"
#include "identification/excerpt.h"
#include "identification/memory_estimate.h"
#include "identification/prediction.h"

namespace hystcan::app {
namespace {

using identification::Dataset;
using identification::ErrorNorms;
using identification::MemoryEstimate;

struct ValidateArguments {
  std::filesystem::path model;
  std::filesystem::path data;
  std::filesystem::path memory;
  std::filesystem::path output;
  DatasetInput input;
  std::optional<double> estimate_s;
  std::optional<double> delay_s;
  bool no_offset = false;
  bool json = false;
};

struct Outcome {
  MemoryEstimate start;
  double delay_s = 0.0;
  std::vector<double> predicted;
  std::size_t estimated_from = 0;  ///< samples
  ErrorNorms all, rest;
  double output_span = 0.0;
  std::size_t outside = 0;  ///< samples beyond the thresholds
};

std::size_t samples_until(const Dataset& dataset, const std::optional<double>& estimate_s) {
  std::size_t samples = 0;
  while (samples < dataset.size() &&
         (!estimate_s || dataset.time_s[samples] - dataset.time_s[0] <= *estimate_s))
    ++samples;
  return samples;
}

Outcome predict(const ValidateArguments& options, const model::Hysteresis& model, const Dataset& given) {
  const Dataset dataset = model.symmetry() == model::Symmetry::even ? folded(given) : given;
  Outcome outcome;
  outcome.delay_s = options.delay_s.value_or(config::load_identified_from(options.model).delay_s);
  if (const double lasts_s = dataset.time_s.back() - dataset.time_s.front();
      options.delay_s && outcome.delay_s > lasts_s)
    throw config::Error(fmt::format("--delay is {} s, expected at most the length of {}, {:g} s",
                                    outcome.delay_s, options.data.string(), lasts_s));
  outcome.output_span = identification::span_of(dataset.output);
  if (!(outcome.output_span > 0.0))
    throw config::Error(fmt::format("{}: the output is constant", options.data.string()));
  if (options.memory.empty()) {
    outcome.estimated_from = samples_until(dataset, options.estimate_s);
    outcome.start =
        estimate_memory(model, dataset, outcome.delay_s, outcome.estimated_from, !options.no_offset);
    outcome.predicted = identification::predict(model, dataset, outcome.delay_s, outcome.start.memory);
  } else {
    model::HysteresisState state =
        config::load_memory(options.memory, model, model::Hysteresis::default_capacity);
    outcome.predicted = identification::predict(model, dataset, outcome.delay_s, state);
  }
  for (double& output : outcome.predicted) output += outcome.start.offset;
  outcome.all = ErrorNorms::of(outcome.predicted, dataset.output);
  outcome.rest = ErrorNorms::of(outcome.predicted, dataset.output, outcome.estimated_from);
  for (const double input : dataset.input) outcome.outside += model.input_range().contains(input) ? 0 : 1;
  return outcome;
}

void write(const ValidateArguments& options, const Dataset& dataset, const Outcome& outcome) {
  stop_at_a_signal();
  OutputFile out(options.output);
  out.write("time_s,input,output,predicted\n");
  fmt::memory_buffer line;
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    line.clear();
    fmt::format_to(std::back_inserter(line), "{:.17g},{:.17g},{:.17g},{:.17g}\n", dataset.time_s[i],
                   dataset.input[i], dataset.output[i], outcome.predicted[i]);
    out.write({line.data(), line.size()});
    if (stop_signalled != 0) throw RunError("stopped, nothing is written");
  }
  out.commit();
}

void report_prediction(const ValidateArguments& options, const Dataset& dataset, const Outcome& outcome) {
  const double percent = 100.0 / outcome.output_span;
  const bool rest = outcome.estimated_from > 0 && outcome.estimated_from < dataset.size();
  if (options.json) {
    fmt::print("{}\n",
               nlohmann::json{
                   {"samples", dataset.size()},
                   {"rms_percent", outcome.all.rms * percent},
                   {"max_percent", outcome.all.max * percent},
                   {"estimated_from_samples", outcome.estimated_from},
                   {"rest_rms_percent", rest ? nlohmann::json(outcome.rest.rms * percent) : nlohmann::json()},
                   {"rest_max_percent", rest ? nlohmann::json(outcome.rest.max * percent) : nlohmann::json()},
                   {"offset", outcome.start.offset},
                   {"delay_s", outcome.delay_s},
                   {"output_span", outcome.output_span},
                   {"samples_outside_thresholds", outcome.outside}}
                   .dump(2));
    return;
  }
  const ErrorNorms& judged = rest ? outcome.rest : outcome.all;
  fmt::print("{}: predicted with {:.3g} % RMS, {:.3g} % at most, of its output span {:.5g} {}\n",
             options.data.string(), judged.rms * percent, judged.max * percent, outcome.output_span,
             dataset.output_unit);
  if (options.memory.empty())
    fmt::print("initial memory{} estimated from {} of {}{}; offset {:+.4g} {}, delay {:.3g} s\n",
               options.no_offset ? "" : " and offset", outcome.estimated_from,
               can::counted(dataset.size(), "sample"), rest ? ", which are not judged" : "",
               outcome.start.offset, dataset.output_unit, outcome.delay_s);
  if (rest)
    fmt::print("with these: {:.3g} % RMS, {:.3g} % at most\n", outcome.all.rms * percent,
               outcome.all.max * percent);
  if (outcome.outside > 0)
    note("{} beyond the model's thresholds, limited to them\n", can::counted(outcome.outside, "sample"));
}

int run_validate(const ValidateArguments& options) {
  for (const auto& input : {options.model, options.data, options.memory})
    refuse_to_overwrite(options.output, input);
  const model::Hysteresis model(config::load_model(options.model));
  DatasetInput input = options.input;
  input.input_unit = model.parameters().input_unit;
  input.output_unit = model.parameters().output_unit;
  const Dataset dataset = load_datasets({options.data}, input).front();
  const Outcome outcome = predict(options, model, dataset);
  if (!options.output.empty()) write(options, dataset, outcome);
  report_prediction(options, dataset, outcome);
  return done;
}

}  // namespace

void add_validate(CLI::App& cli, int& status) {
  auto options = std::make_shared<ValidateArguments>();
  CLI::App* command = cli.add_subcommand("validate", "Predict a dataset with a model, and report the errors");
  command->add_option("MODEL", options->model, "model file (TOML), recursive-memory")->required();
  command->add_option("DATA", options->data, "CSV with time_s,input,output")->required();
  CLI::Option* memory =
      command->add_option("--memory", options->memory, "memory of the actuator at the first row (TOML)");
  command
      ->add_option(
          "--estimate-from", options->estimate_s,
          "estimate initial memory and output offset from this many seconds; if left out, from all rows")
      ->check(positive_number())
      ->excludes(memory);
  command
      ->add_option("--delay", options->delay_s, "delay of the output in seconds, instead of the model file's")
      ->check(not_negative_number());
  command->add_flag("--no-offset", options->no_offset, "do not estimate an output offset")->excludes(memory);
  command->add_option("--output", options->output, "write time_s,input,output,predicted (CSV)");
  add_interval_options(*command, options->input);
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options, &status] { status = run_validate(*options); });
}

}  // namespace hystcan::app
