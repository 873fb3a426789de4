#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line/commands.h"
#include "app/live/stop_signal.h"
#include "app/stage/dataset_input.h"
#include "app/stage/identification_result.h"
#include "app/stage/option_check.h"
#include "app/stage/record_warnings.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "config/files/memory_file.h"
#include "config/files/model_file.h"
#include "config/schema/config.h"
#include "identification/prediction.h"

namespace hystcan::app {
namespace {

using identification::Dataset;
using identification::ErrorNorms;

struct ValidateArguments {
  std::filesystem::path model;
  std::filesystem::path data;
  std::filesystem::path memory;
  std::filesystem::path output;
  DatasetInput input;
  std::optional<double> estimate_s;
  std::optional<double> delay_s;
  bool quasi_static = false;
  bool no_offset = false;
  bool json = false;
};

ValidationOptions validation_options_of(const ValidateArguments& options, const model::Hysteresis& model) {
  identification::Lag lag = config::load_lag(options.model);
  if (options.quasi_static) lag = {.delay_s = lag.delay_s};
  if (options.delay_s) lag.set_delay(*options.delay_s);
  ValidationOptions validation_options{
      .lag = lag, .estimate_s = options.estimate_s, .estimates_offset = !options.no_offset, .memory = {}};
  if (options.memory.empty()) return validation_options;
  validation_options.memory = config::load_memory(options.memory, model, model::Hysteresis::default_capacity);
  if (!options.quasi_static)
    validation_options.crept = config::load_creep_memory(options.memory, model::OutputCreep(lag.creep),
                                                         validation_options.memory->output);
  // Removes the time in the saved state of the creep. The times of the dataset have another origin, so their
  // difference to the saved time has no meaning. The creep continues from the saved state in the first row of
  // the dataset.
  if (validation_options.crept) validation_options.crept->time_s.reset();
  return validation_options;
}

Validation predict(const ValidateArguments& options, const model::Hysteresis& model, const Dataset& dataset) {
  if (const double lasts_s = dataset.time_s.back() - dataset.time_s.front();
      options.delay_s && *options.delay_s > lasts_s)
    throw Error(fmt::format("--delay is {} s", *options.delay_s),
                expect("at most the length of {}, {:g} s", options.data.string(), lasts_s));
  return at_place(options.data,
                  [&] { return validate(model, dataset, validation_options_of(options, model)); });
}

void write(const ValidateArguments& options, const Dataset& dataset, const Validation& outcome) {
  stop_at_a_signal();
  OutputFile out(options.output);
  out.write("time_s,input,output,predicted\n");
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    out.write(fmt::format("{:.17g},{:.17g},{:.17g},{:.17g}\n", dataset.time_s[i], dataset.input[i],
                          dataset.output[i], outcome.predicted[i]));
    throw_if_signalled();
  }
  out.commit();
}

void report_prediction(const ValidateArguments& options, const Dataset& dataset, const Validation& outcome,
                       const std::vector<std::string>& finding_texts) {
  const double percent = 100.0 / outcome.output_span;
  const bool rest = outcome.has_rest();
  if (options.json) {
    nlohmann::json result = validation_json(outcome);
    result["findings"] = finding_texts;
    print("{}\n", result.dump(2));
    return;
  }
  for (const std::string& finding : finding_texts) print("- {}\n", finding);
  const ErrorNorms& judged = rest ? outcome.rest : outcome.all;
  print(
      "{}: predicted with an error of {:.3g} % RMS, {:.3g} % at most, "
      "relative to the output span {:.5g} {}\n",
      options.data.string(), judged.rms * percent, judged.max * percent, outcome.output_span,
      dataset.output_unit);
  if (options.memory.empty())
    print("initial memory{} estimated from {} of {}{}; offset {:+.4g} {}, delay {:.3g} s\n",
          options.no_offset ? "" : " and offset", outcome.estimated_from, counted(dataset.size(), "sample"),
          rest ? " (excluded from the error)" : "", outcome.start.offset, dataset.output_unit,
          outcome.lag.delay());
  if (outcome.lag.dynamics)
    print(
        "the prediction includes the mechanical mode ([dynamics]) of the model file: {:.5g} Hz, damping "
        "ratio {:.3g}\n",
        outcome.lag.dynamics->mode.natural_frequency_Hz, outcome.lag.dynamics->mode.damping_ratio);
  if (outcome.lag.creep)
    print("the prediction includes {} of the model file\n", creep_text(*outcome.lag.creep));
  if (rest)
    print(
        "error over all samples, also those from which the initial memory was estimated: {:.3g} % RMS, "
        "{:.3g} % at most\n",
        outcome.all.rms * percent, outcome.all.max * percent);
  if (outcome.by_rate.size() > 1)
    for (const auto& of : outcome.by_rate)
      print("at about {:.3g} {}/s: error {:.3g} % RMS in {}\n", of.speed, dataset.input_unit,
            of.rms * percent, counted(of.samples, "sample"));
  if (outcome.outside > 0)
    note("limited the inputs of {} to the thresholds of the model\n", counted(outcome.outside, "sample"));
}

int run_validate(const ValidateArguments& options) {
  for (const auto& input : {options.model, options.data, options.memory})
    refuse_to_overwrite_any_of(options.output, input);
  require_run_for_axis({options.data}, options.input);
  const model::Hysteresis model(config::load_model(options.model));
  DatasetInput input = options.input;
  input.input_unit = model.parameters().input_unit;
  input.model_output_unit = model.parameters().output_unit;
  Dataset dataset = load_datasets({options.data}, input).front();
  std::vector<std::string> finding_texts;
  for (const RecordWarning& warning : leave_out_suspects(options.data, dataset))
    finding_texts.push_back(warning.text());
  const Validation outcome = predict(options, model, dataset);
  if (!options.output.empty()) write(options, dataset, outcome);
  report_prediction(options, dataset, outcome, finding_texts);
  return done;
}

}  // namespace

void add_validate(CLI::App& cli, int& status) {
  auto options = std::make_shared<ValidateArguments>();
  CLI::App* command = cli.add_subcommand("validate", "Predict a dataset with a model and report the errors");
  command->add_option("MODEL", options->model, "model file (TOML), recursive-memory")->required();
  command->add_option("DATA", options->data, "CSV with time_s,input,output, or folder of a recorded run")
      ->required();
  command->add_option("--axis", options->input.axis, "axis of the recorded run; default: the only axis");
  CLI::Option* memory =
      command->add_option("--memory", options->memory, "memory of the actuator at the first row (TOML)");
  add_checked(
      *command, "--estimate-from", options->estimate_s, positive_number(),
      "length in seconds of the first part of DATA, from which memory and output offset are estimated; "
      "default: all rows")
      ->excludes(memory);
  add_checked(*command, "--delay", options->delay_s, not_negative_number(),
              "delay of the output behind the input, in seconds; default: from the model file");
  command->add_flag("--quasi-static", options->quasi_static,
                    "ignore [creep] and [dynamics] of the model file");
  command->add_flag("--no-offset", options->no_offset, "do not estimate an output offset")->excludes(memory);
  command->add_option("--output", options->output, "write time_s,input,output,predicted (CSV)");
  add_layout_options(*command, options->input);
  add_interval_options(*command, options->input);
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options, &status] { status = run_validate(*options); });
}

}  // namespace hystcan::app
