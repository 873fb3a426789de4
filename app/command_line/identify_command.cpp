#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line/commands.h"
#include "app/live/stop_signal.h"
#include "app/stage/config_edit.h"
#include "app/stage/dataset_input.h"
#include "app/stage/identification_report.h"
#include "app/stage/identification_result.h"
#include "app/stage/model_words.h"
#include "app/stage/option_check.h"
#include "app/stage/record_warnings.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "base/terminal.h"
#include "base/words.h"
#include "config/document/toml_edit.h"
#include "config/document/toml_text.h"
#include "config/files/memory_file.h"
#include "config/files/model_file.h"
#include "config/schema/settings.h"
#include "identification/dynamics/joint_dynamics.h"
#include "identification/identify.h"
#include "identification/old_model.h"

namespace hystcan::app {
namespace {

using identification::Dataset;
using identification::Identified;

struct IdentifyArguments {
  std::vector<std::filesystem::path> data;
  std::filesystem::path start;  ///< older model; parts that the datasets do not determine are copied from it
  std::filesystem::path output;
  std::filesystem::path initial_memory;
  std::filesystem::path report;
  DatasetInput input;
  /// Does not contain `model`, `symmetry` and `thresholds`, which are words of the command line.
  /// identify_options_of() adds these three options.
  identification::IdentifyOptions identify_options;
  ModelWords model;
  bool dynamics = false;
  std::string symmetry = "auto";
  std::string thresholds = "auto";
  bool json = false;
  bool overwrite = false;
  std::filesystem::path config;   ///< configuration that gets the new model; empty if none
  std::filesystem::path written;  ///< copy of the configuration that contains the new model
};

identification::IdentifyOptions identify_options_of(const IdentifyArguments& options, Progress& progress) {
  identification::IdentifyOptions identify_options = options.identify_options;
  options.model.apply_to(identify_options);
  identify_options.output = *parse_word<identification::ShapeOfOutput>(options.symmetry);
  identify_options.observed_thresholds = options.thresholds == "observed";
  identify_options.go_on = counted_trials(progress);
  return identify_options;
}

Identified identify(const IdentifyArguments& options, const std::vector<Dataset>& datasets,
                    const std::optional<identification::OldModel>& old) {
  Progress progress("identifying", 0, "trials");
  std::string names;
  for (const auto& file : options.data) names += (names.empty() ? "" : ", ") + file.string();
  return at_place(names, [&] {
    const identification::IdentifyOptions identify_options = identify_options_of(options, progress);
    if (old) return identification::identify_from(*old, datasets, identify_options);
    return options.dynamics ? identification::identify_dynamics(datasets, identify_options)
                            : identification::identify(datasets, identify_options);
  });
}

void save_memory(const IdentifyArguments& options, const Dataset& dataset, const Identified& identified) {
  const model::Hysteresis model(identified.parameters);
  const auto state = state_of(model, identified.memories.front(), dataset.input.front());
  OutputFile out(options.initial_memory);
  out.write(config::memory_text(model, state));
  out.commit();
}

/// Returns a sentence for the report: which part of the new model the datasets determine, and which part is
/// copied from the older model `file`.
std::string finding_of_old(const std::filesystem::path& file, const identification::OldModel& old,
                           const std::vector<Dataset>& datasets) {
  const model::Interval& known = old.parameters.input_range();
  model::Interval moved{datasets.front().input.front(), datasets.front().input.front()};
  for (const Dataset& dataset : datasets) {
    const auto [least, most] = std::ranges::minmax(dataset.input);
    moved = {std::min(moved.lo, least), std::max(moved.hi, most)};
  }
  const double slack = 0.01 * known.span();
  const bool covers = moved.lo <= known.lo + slack && moved.hi >= known.hi - slack;
  return fmt::format(
      "the inputs range from {:.4g} to {:.4g} {}, the thresholds (ends of the input range) of the model "
      "{} are {:.4g} and {:.4g}: {}the parameters that the datasets do not determine are copied from {}{}",
      moved.lo, moved.hi, datasets.front().input_unit, file.string(), known.lo, known.hi,
      covers ? "" : "the curves beyond these inputs and ",
      file.string() + (old.creep ? "" : " (a model without creep)"),
      config::load_lag(file).dynamics ? ", except [dynamics]" : "");
}

/// Returns the name of a file or folder without its path. The path of a folder may end in a slash.
std::string name_of(const std::filesystem::path& path) {
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

void report_model(const IdentifyArguments& options, const std::vector<Dataset>& datasets,
                  const Identified& identified, const std::vector<std::string>& finding_texts) {
  std::vector<std::string> names;
  for (const auto& file : options.data) names.push_back(name_of(file));
  if (const auto undrawn = write_report(options.report, {datasets, names, identified, finding_texts}))
    note("hystcan: {}: {}\n", options.report.string(), *undrawn);
}

/// Loads the configuration into which the new model will be inserted. Its model file need not exist yet.
config::Config config_to_complete(const IdentifyArguments& options) {
  config::Config config = config::load_unmeasured(options.config);
  refuse_to_write_into(options.written, config, options.output);
  for (const auto& file : options.data) refuse_to_overwrite_any_of(options.written, file);
  index_of_axis(config, options.input.axis);
  return config;
}

void write_config(const IdentifyArguments& options, const config::Config& config) {
  std::error_code none;
  auto model = std::filesystem::relative(std::filesystem::absolute(options.output),
                                         std::filesystem::absolute(config.file).parent_path(), none);
  if (none) model = std::filesystem::absolute(options.output);
  config::TomlEdit text = config::TomlEdit::of_file(config.file);
  text.set(path_of(config, config.axes[index_of_axis(config, options.input.axis)].control_model),
           config::toml_string(model.string()));
  write_file(options.written, text.text());
  try {
    config::load(options.written);
  } catch (const std::runtime_error& error) {
    note("hystcan: {}: written, but not yet a valid configuration: {}\n", options.written.string(),
         error.what());
  }
}

// Throws if an output file would replace an input file, another output or, without --overwrite, an existing
// file. Called before the slow identification.
void check_outputs(const IdentifyArguments& options) {
  for (const auto& file : options.data)
    for (const auto& output : {options.output, options.initial_memory})
      refuse_to_overwrite_any_of(output, file);
  for (const auto& output : {options.output, options.initial_memory})
    for (const auto& input : {options.start, options.input.layout.output_from})
      refuse_to_overwrite(output, input);
  for (const auto& output : {options.output, options.initial_memory})
    refuse_to_replace(output, options.overwrite);
  if (!options.initial_memory.empty()) refuse_to_share(options.output, options.initial_memory);
  if (options.report.empty()) return;
  refuse_as_folder(options.report);
  for (const std::string& name : report_files()) {
    for (const auto& file : options.data) refuse_to_overwrite_any_of(options.report / name, file);
    refuse_to_share(options.report / name, options.output);
    if (!options.initial_memory.empty()) refuse_to_share(options.report / name, options.initial_memory);
  }
}

int run_identify(const IdentifyArguments& options) {
  check_outputs(options);
  if (options.config.empty()) require_run_for_axis(options.data, options.input, ", or --for");
  OutputFile out(options.output);
  std::optional<config::Config> config;
  if (!options.config.empty()) config = config_to_complete(options);
  std::optional<identification::OldModel> old;
  DatasetInput input = options.input;
  if (!options.start.empty()) {
    const identification::Lag lag = config::load_lag(options.start);
    old = {config::load_model(options.start), lag.delay_s, lag.creep};
    input.input_unit = old->parameters.input_unit;
    input.model_output_unit = old->parameters.output_unit;
  }
  std::vector<Dataset> datasets = load_datasets(options.data, input);
  refuse_same_rows(options.data, datasets);
  std::vector<std::string> finding_texts;
  for (std::size_t i = 0; i < datasets.size(); ++i)
    for (const RecordWarning& warning : leave_out_suspects(options.data[i], datasets[i]))
      finding_texts.push_back(warning.text());
  stop_at_a_signal();
  const Identified identified = identify(options, datasets, old);
  std::ranges::move(findings(datasets, identified), std::back_inserter(finding_texts));
  if (old) finding_texts.push_back(finding_of_old(options.start, *old, datasets));
  out.write(identified_model_text(identified, datasets, finding_texts));
  out.commit();
  if (config) write_config(options, *config);
  if (!options.initial_memory.empty()) save_memory(options, datasets.front(), identified);
  if (!options.report.empty()) report_model(options, datasets, identified, finding_texts);
  const double percent = 100.0 / identified.output_span;
  if (options.json) {
    print("{}\n", identification_json(identified, finding_texts).dump(2));
  } else {
    for (const std::string& finding : finding_texts) print("- {}\n", finding);
    print(
        "{}: {}, {} parameters, "
        "error {:.3g} % RMS, {:.3g} % at most{}, relative to the output span {:.5g} {}\n",
        options.output.string(), identified.search.shape.text(), identified.parameter_count(),
        identified.overall.rms * percent, identified.overall.max * percent,
        identified.held_out_rms
            ? fmt::format(" ({:.3g} % RMS cross-validated)", *identified.held_out_rms * percent)
            : "",
        identified.output_span, identified.parameters.output_unit);
  }
  return done;
}

}  // namespace

void add_identify(CLI::App& cli, int& status) {
  auto options = std::make_shared<IdentifyArguments>();
  CLI::App* command =
      cli.add_subcommand("identify", "Identify a model from a measured dataset and write its model file");
  command
      ->add_option(
          "DATA", options->data,
          "CSV with time_s,input,output, or folder of a recorded run; several files or folders together "
          "give one model")
      ->required();
  command->add_option("--output", options->output, "model file to write (TOML)")->required();
  CLI::Option* start = command->add_option(
      "--start", options->start,
      "old recursive-memory model (TOML); parts that the datasets do not determine are copied from it");
  command->add_flag("--overwrite", options->overwrite, "replace existing files");
  add_model_options(*command, options->model);
  CLI::Option* delay =
      add_checked(*command, "--delay", options->identify_options.delay_s, not_negative_number(),
                  "known delay of the output behind the input, in seconds");
  add_checked(*command, "--delay-max", options->identify_options.longest_delay_s, not_negative_number(),
              "maximum delay of the output behind the input that the search tries, in seconds")
      ->excludes(delay);
  command->add_flag("--common-zero", options->identify_options.common_zero,
                    "assume the same output zero for all datasets; default: each dataset has its own zero");
  command->add_flag(
      "--common-gain", options->identify_options.common_gain,
      "assume the same output gain for all datasets; default: each dataset can have its own gain");
  command->add_flag("--drift", options->identify_options.drift,
                    "assume that the zero of each dataset drifts linearly in time");
  command
      ->add_flag("--dynamics", options->dynamics,
                 "also identify a mechanical mode and a delay, from fast, evenly sampled datasets")
      ->excludes(start);
  add_checked(
      *command, "--symmetry", options->symmetry, one_of(words(identification::ShapeOfOutput{})),
      "even: inputs v and -v give the same output; butterfly: the lowest output is at v > 0 if v rises, "
      "and at v < 0 if v falls");
  add_checked(
      *command, "--thresholds", options->thresholds, one_of({"auto", "observed"}),
      "ends of the input range of the model: `observed`, the lowest and the highest measured input, or "
      "`auto` (default), beyond these inputs if this lowers the error");
  command->add_option(
      "--initial-memory", options->initial_memory,
      "file for the memory at the start of the first dataset, which simulate --memory can read");
  command->add_option("--report", options->report,
                      "folder for report.html: loops, residuals, curves, comparison with other models");
  add_dataset_options(*command, options->input);
  CLI::Option* with_config =
      command->add_option("--for", options->config, "configuration (TOML) that will use the model");
  command->add_option(
      "--axis", options->input.axis,
      "axis of the recorded runs and of --for; default: the only axis of a run, the first axis of --for");
  CLI::Option* written = command->add_option(
      "--write", options->written,
      "new configuration (TOML): a copy of the file of --for, in which the axis uses the new model");
  written->needs(with_config);
  with_config->needs(written);
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options, &status] { status = run_identify(*options); });
}

}  // namespace hystcan::app
