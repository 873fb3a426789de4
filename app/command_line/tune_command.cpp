#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "app/command_line/commands.h"
#include "app/live/report.h"
#include "app/stage/axis_completion.h"
#include "app/stage/cautious_excitation.h"
#include "app/stage/config_edit.h"
#include "app/stage/open_loop.h"
#include "app/stage/option_check.h"
#include "app/stage/stage_records.h"
#include "app/stage/tuning.h"
#include "app/stage/tuning_report.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "config/schema/config.h"
#include "identification/dataset.h"

namespace hystcan::app {
namespace {

using controller::CautiousRule;
using controller::Excitation;
using identification::Dataset;

struct TuneArguments {
  OpenLoopOptions run;
  std::filesystem::path output = "tuning.toml";
  std::filesystem::path written, picture, table;  ///< output files of --write, --plot and --response; empty:
                                                  ///< the option is not given
  std::filesystem::path record;                   ///< existing record of a step response; empty: the command
                                                  ///< drives the stage and records one
  config::DatasetLayout layout{};                 ///< how to read `record`: columns, rate, scale
  std::optional<double> centre, amplitude;
  double period_s = 0.4;
  unsigned cycles = 5;
  controller::SensitivityRule sensitivity;
  bool cautious = false;
  double phase_margin_deg = CautiousRule{}.phase_margin_deg;
  std::optional<double> gain_margin_dB;
  bool json = false;
};

Excitation::Steps steps(const TuneArguments& options, const controller::Gate::Config& gate) {
  const double range = gate.drive_max - gate.drive_min;
  return {.centre = options.centre.value_or(gate.drive_min + range / 2.0),
          .amplitude = options.amplitude.value_or(0.01 * range),
          .period_s = options.period_s,
          .cycles = options.cycles};
}

CautiousRule cautious_rule(const TuneArguments& options) {
  CautiousRule rule{.phase_margin_deg = options.phase_margin_deg};
  if (options.gain_margin_dB) rule.gain_margin = std::pow(10.0, *options.gain_margin_dB / 20.0);
  return rule;
}

/// Returns the steps of the experiment. Their amplitude is the option --amplitude. Without this option, the
/// default amplitude is halved until the steps keep a margin from the limits of the stage in a rehearsal with
/// the twin.
Excitation::Steps chosen_steps(const TuneArguments& options, const config::Config& config,
                               const twin::Config& twin) {
  const Excitation::Steps stated = steps(options, config.axes[0].control.gate);
  in_open_loop(config, stated);  // throws if the steps exceed the drive range
  return options.amplitude ? stated : std::get<Excitation::Steps>(with_margin(config, twin, stated));
}

/// Opens the requested output files before the axis moves, so that an unwritable file stops the command
/// early.
struct RequestedFiles {
  RequestedFiles(const TuneArguments& options, const config::Config& loaded) {
    refuse_to_overwrite_inputs(options.output, options.run.config, loaded);
    for (const auto& file : {options.output, options.table, options.picture})
      refuse_to_overwrite(file, options.record);
    if (!options.written.empty()) {
      refuse_to_write_into(options.written, loaded, options.output, options.record);
      written.emplace(options.written);
    }
    if (!options.table.empty()) {
      refuse_to_overwrite_inputs(options.table, options.run.config, loaded);
      refuse_to_share(options.table, options.output);
      table.emplace(options.table);
    }
    if (!options.picture.empty()) {
      require_picture(options.picture);
      refuse_to_overwrite_inputs(options.picture, options.run.config, loaded);
    }
    fragment.emplace(options.output);
  }
  std::optional<OutputFile> fragment, written, table;
};

void put(std::optional<OutputFile>& file, const std::string& text) {
  file->write(text);
  file->commit();
}

/// The step record and the plant identified from it. The proposed gains are computed from this plant.
struct Measured {
  Dataset record;
  IdentifiedPlant plant;
};

Measured measured_before(const TuneArguments& options, const config::Config& config, TuningReport& report) {
  AxisRecords records{.loop_files = {}, .step_file = options.record};
  DatasetInput input;
  input.axis = report.axis;
  input.input_unit = report.drive_unit;
  input.layout = options.layout;
  // The argument `true` accepts a record with drop-outs or glitches and prints a warning. This is safe here,
  // because no limit of the stage, such as its position limits, is computed from a step record.
  load(records, input, true);
  report.record = options.record.filename().string();
  return {*records.step, *shown_plant(records, config.axes[0].control.delays)};
}

Measured measured_now(const TuneArguments& options, const config::Config& config, const twin::Config& twin,
                      TuningReport& report) {
  report.steps = chosen_steps(options, config, twin);
  report.rehearsed = options.run.rehearse;
  Dataset record = measured_steps(config, twin, options.run, report.steps);
  IdentifiedPlant plant = plant_of_steps(record, config);
  return {std::move(record), std::move(plant)};
}

int tune(const TuneArguments& options) {
  const config::Config loaded = config::load(options.run.config);
  RequestedFiles files(options, loaded);
  const config::Config config = chosen_axis_of(loaded, options.run);
  // The twin simulates all axes, because they share the bus with the tuned axis.
  const twin::Config twin = twin_config(loaded);
  TuningReport report = tuning_of(config);
  report.rule = options.sensitivity;
  report.cautious_rule = cautious_rule(options);
  report.only_cautious = options.cautious;
  const auto& [record, plant] = options.record.empty() ? measured_now(options, config, twin, report)
                                                       : measured_before(options, config, report);
  evaluate(report, plant, config, twin);
  predict_further(report, config, twin);
  put(files.fragment, fragment(report));
  if (files.table) put(files.table, response_table(report, record));
  if (files.written)
    put(files.written, with_loop(loaded, index_of_axis(loaded, options.run.axis), report.proposed().loop));
  if (!options.picture.empty())
    if (const auto failure = draw_response(report, record, options.picture))
      note("{}: not drawn: {}\n", options.picture.string(), *failure);
  print("{}", options.json ? to_json(report).dump(2) + "\n" : describe(report));
  note("{}: proposed, not applied\n", options.output.string());
  return done;
}

}  // namespace

void add_tune(CLI::App& cli, int& status) {
  auto options = std::make_shared<TuneArguments>();
  CLI::App* command = cli.add_subcommand(
      "tune", "Identify resonance, damping and delay with small open-loop steps, and propose PI gains");
  command->add_option("CONFIG", options->run.config, "configuration (TOML), which is not changed")
      ->required();
  command
      ->add_option("--output", options->output,
                   "output file (TOML) with the proposed keys of a configuration")
      ->capture_default_str();
  command->add_option(
      "--write", options->written,
      "new configuration (TOML) in the folder of CONFIG: a copy of CONFIG with the proposed values");
  command->add_option(
      "--response", options->table,
      "output file (CSV) with frequency responses: measurement, model, present loop, proposed loop");
  command->add_option("--plot", options->picture,
                      "picture of the frequency response, drawn with matplotlib (.svg, .png)");
  CLI::Option* record = command->add_option(
      "--record", options->record,
      "record of small steps or a chirp instead of an experiment (CSV: time_s,input,output, evenly sampled)");
  add_column_options(*command, options->layout);
  for (const char* of_record : {"--columns", "--output-from", "--output-scale"})
    command->get_option(of_record)->needs(record);
  add_checked(*command, "--centre", options->centre, finite_number(),
              "drive at the centre of the steps; default: the middle of drive_min and drive_max");
  add_checked(*command, "--amplitude", options->amplitude, positive_number(),
              "amplitude of the steps in drive units; default: 1 % of drive_max - drive_min");
  add_checked(*command, "--period", options->period_s, positive_number(), "seconds per step up and down")
      ->capture_default_str();
  add_checked(*command, "--cycles", options->cycles, whole_number(1, Excitation::most_turns),
              "number of steps up and down")
      ->capture_default_str();
  CLI::Option* cautious = command->add_flag(
      "--cautious", options->cautious,
      "propose only gains with wide stability margins, with which the true delay may be longer than the "
      "identified one");
  add_checked(*command, "--peak-sensitivity", options->sensitivity.peak_sensitivity,
              number_between(1.05, 10.0),
              "maximum sensitivity |1 / (1 + L)| (L: transfer function of the open loop)")
      ->excludes(cautious)
      ->capture_default_str();
  add_checked(*command, "--resonance-percent", options->sensitivity.resonance_percent,
              number_between(0.0, 50.0),
              "percent by which the identified interval of the resonance is widened on both sides")
      ->capture_default_str();
  add_checked(*command, "--phase-margin", options->phase_margin_deg, number_between(0.1, 89.9),
              "with --cautious: phase margin, degrees")
      ->needs(cautious)
      ->capture_default_str();
  add_checked(*command, "--gain-margin", options->gain_margin_dB, number_between(0.1, 60.0),
              "gain margin in dB; default: 6.02 dB, a factor of 2")
      ->needs(cautious);
  command->add_flag("--json", options->json, "print the result as JSON");
  add_open_loop_options(*command, options->run);
  for (const char* of_experiment :
       {"--centre", "--amplitude", "--period", "--cycles", "--interface", "--clear-faults", "--rehearse"})
    record->excludes(command->get_option(of_experiment));
  command->callback([options, &status] { status = tune(*options); });
}

}  // namespace hystcan::app
