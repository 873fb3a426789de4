#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/commands/commands.h"
#include "app/commands/tune_candidates.h"
#include "app/io/option_check.h"
#include "app/io/output_file.h"
#include "app/io/standard_streams.h"
#include "app/live/open_loop.h"
#include "app/live/safe_amplitude.h"
#include "app/live/stop_signal.h"
#include "app/report/config_edit.h"
#include "app/report/dynamics_text.h"
#include "app/report/frequency_response.h"
#include "app/report/report.h"
#include "app/report/tuning_report.h"
#include "config/schema/config.h"
#include "controller/excitation_dataset.h"
#include "identification/dataset.h"
#include "identification/dynamics/empirical_response.h"

namespace hystcan::app {
namespace {

using controller::CautiousRule;
using controller::Excitation;
using identification::Dataset;
using identification::SecondOrderFit;

struct TuneArguments {
  OpenLoopOptions run;
  std::filesystem::path output = "tuning.toml";
  std::filesystem::path written, picture, table;  ///< empty: not asked for
  std::optional<double> centre, amplitude;
  double period_s = 0.4;
  unsigned cycles = 5;
  controller::SensitivityRule sensitivity;
  bool cautious = false;
  double phase_margin_deg = CautiousRule{}.phase_margin_deg;
  std::optional<double> gain_margin_dB;
  bool json = false;
};

/// Steps up and down around the middle of the stroke, by default with 1 % of the range of the drive.
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

/// Drive and position in every cycle of the experiment. The rows have the times of whole cycles: sample and
/// drive both follow the SYNC, so that its jitter of some microseconds does not affect the identified mode.
Dataset measure(const config::Config& config, const twin::Config& twin, const TuneArguments& options) {
  const config::AxisConfig& axis = config.axes[0];
  const double rate_Hz = config.controller.rate_Hz;
  Dataset record{
      .input_unit = axis.wire.drive_unit, .output_unit = "um", .time_s = {}, .input = {}, .output = {}};
  controller::ExcitationDataset rows;
  const OpenLoopEnd end =
      drive_in_open_loop(config, twin, options.run, [&](const controller::CycleRecord& cycle) {
        const auto row = rows.add(cycle);
        if (!row) return;
        record.time_s.push_back(std::round(row->time_s * rate_Hz) / rate_Hz);
        record.input.push_back(row->input);
        record.output.push_back(row->output);
      });
  for (const std::string& text : end.closing) note("{}\n", text);
  end.require_finished(axis.wire.name, "stopped before the end of the experiment, nothing is written");
  return record;
}

SecondOrderFit fit(const Dataset& record) {
  try {
    return identification::fit_second_order(record);
  } catch (const std::invalid_argument& error) {
    throw RunError(fmt::format(
        "the experiment is not conclusive: {}; nothing is written. Try another --amplitude: a large step "
        "shows the curvature of the loop, a small one is hidden by noise",
        error.what()));
  }
}

/// The stated amplitude, or the default one, made smaller where the twin comes near a limit with it.
Excitation::Steps chosen_steps(const TuneArguments& options, const config::Config& config,
                               const twin::Config& twin) {
  Excitation::Steps chosen = steps(options, config.axes[0].control.gate);
  in_open_loop(config, chosen);  // refuses what is outside the range
  if (options.amplitude) return chosen;
  const double usual = chosen.amplitude;
  chosen.amplitude = amplitude_with_margin(config, twin, usual, [&](double amplitude) {
    Excitation::Steps smaller = chosen;
    smaller.amplitude = amplitude;
    return smaller;
  });
  if (chosen.amplitude < usual)
    note("amplitude {:g} {}, not {:g}: the twin comes near a limit with more\n", chosen.amplitude,
         config.axes[0].wire.drive_unit, usual);
  return chosen;
}

/// The files that were asked for, opened before the axis moves.
struct AskedFiles {
  AskedFiles(const TuneArguments& options, const config::Config& loaded) {
    refuse_to_overwrite_inputs(options.output, options.run.config, loaded);
    if (!options.written.empty()) {
      refuse_to_write_into(options.written, loaded, options.output);
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
  if (!file) return;
  file->write(text);
  file->commit();
}

FrequencyResponse response_of(const TuningReport& report, const Dataset& record) {
  const auto loop = [&](const Candidate& of) -> FrequencyResponse::Loop {
    return {{.delays = report.plant.delays,
             .cycle_s = report.fit.cycle_s,
             .measurement_filter_Hz = of.setting.measurement_filter_Hz,
             .notch = of.setting.notch},
            of.setting.pi};
  };
  return {.title = fmt::format("axis {} of {}: {}", report.axis, report.config, report.proposed().name),
          .measured = identification::empirical_response(record),
          .fit = report.fit,
          .before = loop(report.present()),
          .after = loop(report.proposed())};
}

int tune(const TuneArguments& options) {
  const CandidateRules rules{options.sensitivity, cautious_rule(options), options.cautious};
  const config::Config loaded = config::load(options.run.config);
  AskedFiles files(options, loaded);
  const config::Config config = chosen_axis_of(loaded, options.run);
  const twin::Config twin = twin_config(loaded);  // whole, as the bus has all its nodes
  const config::AxisConfig& axis = config.axes[0];
  TuningReport report{.config = config.file.filename().string(),
                      .axis = axis.wire.name,
                      .drive_unit = axis.wire.drive_unit,
                      .actuator = axis.twin_model.string(),
                      .rehearsed = options.run.rehearse,
                      .steps = chosen_steps(options, config, twin),
                      .rate_Hz = config.controller.rate_Hz,
                      .fit = {},
                      .plant = {},
                      .rule = rules.sensitivity,
                      .cautious_rule = rules.cautious,
                      .only_cautious = rules.only_cautious,
                      .candidates = {},
                      .best = 0};
  const Dataset record = measure(in_open_loop(config, report.steps), twin, options);
  report.fit = fit(record);
  report.plant = identified_plant(record, report.fit, axis.control.delays);
  report.plant.delays.command_delay = std::chrono::nanoseconds(std::llround(1e9 / report.rate_Hz));
  stop_at_a_signal();
  report.candidates = rehearsed_candidates(config, twin, report.plant, rules);
  report.best = best_of(report.candidates, rules.only_cautious ? std::numeric_limits<double>::infinity()
                                                               : rules.sensitivity.peak_sensitivity);
  if (!report.proposed().has_run())
    throw RunError(
        "no candidate tracks the configured reference in the rehearsal, nothing is written: look at its limits "
        "and at [axis.twin] with `hystcan demo`");
  predict_structures(report.candidates[0], config, twin, report.plant);
  if (report.best > 0) predict_structures(report.candidates[report.best], config, twin, report.plant);
  const FrequencyResponse response = response_of(report, record);
  const Candidate& best = report.proposed();
  put(files.fragment, fragment(report));
  put(files.table, table_of(response));
  put(files.written,
      with_loop_keys(loaded, index_of_axis(loaded, options.run.axis), {best.setting, best.delays}));
  if (!options.picture.empty())
    if (const std::string failure = draw(response, options.picture); !failure.empty())
      note("{}: not drawn: {}\n", options.picture.string(), failure);
  fmt::print("{}", options.json ? to_json(report).dump(2) + "\n" : describe(report));
  note("{}: proposed, not applied\n", options.output.string());
  return done;
}

}  // namespace

void add_tune(CLI::App& cli, int& status) {
  auto options = std::make_shared<TuneArguments>();
  CLI::App* command = cli.add_subcommand(
      "tune", "Identify resonance, damping and delay by small steps in open loop; propose PI gains");
  command->add_option("CONFIG", options->run.config, "configuration (TOML); it is not changed")->required();
  command->add_option("--output", options->output, "fragment of a configuration to write (TOML)")
      ->capture_default_str();
  command->add_option("--write", options->written,
                      "copy of CONFIG to write, with the proposal in it; beside CONFIG (TOML)");
  command->add_option("--response", options->table,
                      "frequency response to write: measured, model, loops (CSV)");
  command->add_option("--plot", options->picture, "picture of it to draw with gnuplot (.svg, .png)");
  command->add_option("--centre", options->centre, "drive; the middle of drive_min and drive_max")
      ->check(finite_number());
  command->add_option("--amplitude", options->amplitude, "drive units; 1 % of drive_max - drive_min")
      ->check(positive_number());
  command->add_option("--period", options->period_s, "seconds of one step up and down")
      ->check(positive_number())
      ->capture_default_str();
  command->add_option("--cycles", options->cycles, "steps up and down")
      ->check(whole_number(1, Excitation::most_turns))
      ->capture_default_str();
  CLI::Option* cautious = command->add_flag(
      "--cautious", options->cautious,
      "only the rule that counts no phase beyond -180 degrees; stays stable with any delay");
  command
      ->add_option("--peak-sensitivity", options->sensitivity.peak_sensitivity,
                   "largest |1 / (1 + L)| of the proposed loop")
      ->check(number_between(1.05, 10.0))
      ->excludes(cautious)
      ->capture_default_str();
  command
      ->add_option("--resonance-percent", options->sensitivity.resonance_percent,
                   "the resonance may be this far outside its interval")
      ->check(number_between(0.0, 50.0))
      ->capture_default_str();
  command->add_option("--phase-margin", options->phase_margin_deg, "with --cautious: phase margin, degrees")
      ->check(number_between(0.1, 89.9))
      ->needs(cautious)
      ->capture_default_str();
  command
      ->add_option("--gain-margin", options->gain_margin_dB,
                   "with --cautious: gain margin, dB (a factor of 2)")
      ->check(number_between(0.1, 60.0))
      ->needs(cautious);
  command->add_flag("--json", options->json, "print the result as JSON");
  add_open_loop_options(*command, options->run);
  command->callback([options, &status] { status = tune(*options); });
}

}  // namespace hystcan::app
