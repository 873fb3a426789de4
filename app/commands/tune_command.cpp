#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/commands/commands.h"
#include "app/io/option_check.h"
#include "app/io/output_file.h"
#include "app/io/standard_streams.h"
#include "app/live/open_loop.h"
#include "app/live/rehearsal_setup.h"
#include "app/live/stop_signal.h"
#include "app/report/dynamics_text.h"
#include "app/report/report.h"
#include "app/report/tuning_report.h"
#include "config/schema/config.h"
#include "controller/excitation_dataset.h"
#include "identification/dataset.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {
namespace {

using controller::CautiousRule;
using controller::Excitation;
using identification::Dataset;
using identification::SecondOrderFit;

struct TuneArguments {
  OpenLoopOptions run;
  std::filesystem::path output = "tuning.toml";
  std::optional<double> centre, amplitude;
  double period_s = 0.4;
  unsigned cycles = 5;
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

CautiousRule rule(const TuneArguments& options) {
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

Setting proposal(const Setting& present, const IdentifiedPlant& plant, const CautiousRule& rule,
                 double cycle_s) {
  Setting proposed = present;
  proposed.delays = plant.delays;
  proposed.delays.command_delay = std::chrono::nanoseconds(std::llround(1e9 * cycle_s));
  const controller::LoopConfig loop{.delays = proposed.delays, .cycle_s = cycle_s};
  proposed.pi = controller::largest_gains(loop, rule);
  proposed.loop = controller::judge(loop, plant.uncertainty, proposed.pi);
  return proposed;
}

/// Sets the identified mode in the twin. The amplifier's lag represents the delay, if there is one.
void set_mode(twin::Config& twin, const std::string& axis_name, const SecondOrderFit& found) {
  for (twin::WiredAxisConfig& axis : twin.axes) {
    if (axis.wire.name != axis_name) continue;
    twin::Plant::Config& plant = axis.axis.plant;
    plant.mode = found.mode();
    plant.amplifier.bandwidth_Hz = bandwidth_Hz_for(found.delay_s).value_or(plant.amplifier.bandwidth_Hz);
  }
}

/// Runs the configured reference with each structure in virtual time.
void predict(Setting& setting, const config::Config& config, const twin::Config& twin,
             const SecondOrderFit& found) {
  rehearsal::Setup setup = rehearsal_setup(config, twin);
  controller::AxisConfig& axis = setup.controller.axes[0].axis;
  axis.law.pi = setting.pi;
  axis.delays = setting.delays;
  set_mode(setup.twin, config.axes[0].wire.name, found);
  setting.predicted.reserve(controller::all_structures.size());
  for (const controller::Structure structure : controller::all_structures) {
    rehearsal::Outcome outcome =
        rehearsal::run_once(with_structure(setup, structure), settle_s, [](const controller::CycleRecord&) {
          if (stop_signalled != 0) throw RunError("stopped, nothing is written");
        });
    setting.predicted.push_back(std::move(outcome.axes[0]));
  }
}

int tune(const TuneArguments& options) {
  const CautiousRule asked = rule(options);
  const config::Config loaded = config::load(options.run.config);
  refuse_to_overwrite_inputs(options.output, options.run.config, loaded);
  const config::Config config = chosen_axis_of(loaded, options.run);
  const twin::Config twin = twin_config(loaded);  // whole, as the bus has all its nodes
  const config::AxisConfig& axis = config.axes[0];
  const double cycle_s = 1.0 / config.controller.rate_Hz;
  TuningReport report{.config = config.file.filename().string(),
                      .axis = axis.wire.name,
                      .drive_unit = axis.wire.drive_unit,
                      .actuator = axis.twin_model.string(),
                      .rehearsed = options.run.rehearse,
                      .steps = steps(options, axis.control.gate),
                      .rate_Hz = config.controller.rate_Hz,
                      .fit = {},
                      .rule = asked,
                      .present = {.pi = axis.control.law.pi, .delays = axis.control.delays},
                      .proposed = {}};
  const config::Config experiment = in_open_loop(config, report.steps);
  OutputFile out(options.output);  // fails before the axis moves if it cannot be written
  report.fit = fit(measure(experiment, twin, options));
  stop_at_a_signal();
  const IdentifiedPlant plant = plant_of(report.fit, report.present.delays);
  const controller::LoopConfig loop = controller::loop_config_of(axis.control.law, plant.delays, cycle_s);
  if (report.present.pi.ki_per_s > 0.0)
    report.present.loop = controller::judge(loop, plant.uncertainty, report.present.pi);
  report.proposed = proposal(report.present, plant, asked, cycle_s);
  predict(report.present, config, twin, report.fit);
  predict(report.proposed, config, twin, report.fit);
  out.write(fragment(report));
  out.commit();
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
  command
      ->add_option("--phase-margin", options->phase_margin_deg, "phase margin of the proposed gains, degrees")
      ->check(number_between(0.1, 89.9))
      ->capture_default_str();
  command
      ->add_option("--gain-margin", options->gain_margin_dB,
                   "gain margin of the proposed gains, dB (a factor of 2)")
      ->check(number_between(0.1, 60.0));
  command->add_flag("--json", options->json, "print the result as JSON");
  add_open_loop_options(*command, options->run);
  command->callback([options, &status] { status = tune(*options); });
}

}  // namespace hystcan::app
