#include "app/stage/axis_completion.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "app/live/rehearsal_setup.h"
#include "app/live/report.h"
#include "app/live/stop_signal.h"
#include "app/stage/config_edit.h"
#include "app/stage/dynamics_text.h"
#include "app/stage/first_stage.h"
#include "app/stage/identification_report.h"
#include "app/stage/identification_result.h"
#include "app/stage/tuning.h"
#include "base/error.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "base/terminal.h"
#include "config/document/toml_edit.h"
#include "config/files/model_file.h"
#include "config/schema/settings.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {
namespace {

using identification::Dataset;
using identification::Identified;

void stop_if_signalled() {
  if (stop_signalled != 0) throw RunError("stopped, nothing is written");
}

Identified identified_loops(const AxisRecords& records) {
  Progress progress("identifying", 0, "trials");
  identification::IdentifyOptions asked = records.model;
  asked.observed_thresholds = true;  // so that the start-up reaches both
  asked.go_on = [&progress, tries = std::uint64_t{0}]() mutable {
    progress.update(++tries);
    return stop_signalled == 0;
  };
  try {
    return identification::identify(records.loops, asked);
  } catch (const std::invalid_argument& error) {
    throw Error(fmt::format("{}: {}", fmt::join(records.names(), ", "), error.what()));
  }
}

/// Returns why the report has no pictures, if it has none.
std::optional<std::string> write_axis_report(const std::filesystem::path& folder, const AxisRecords& records,
                                             const Identified& found, const std::vector<std::string>& said) {
  Progress progress("comparing models", 0, "trials");
  return write_report(folder, {records.loops, records.names(), found, said},
                      [&progress, tries = std::uint64_t{0}]() mutable {
                        progress.update(++tries);
                        return stop_signalled == 0;
                      });
}

std::string validation_line(const model::HysteresisParameters& parameters, double delay_s,
                            const AxisRecords& records) {
  const Validation seen =
      validate(model::Hysteresis(parameters), *records.unseen,
               {.lag = {.delay_s = delay_s, .dynamics = {}}, .estimate_s = {}, .memory = {}});
  return fmt::format("unseen: {} is predicted with {:.3g} % RMS, {:.3g} % at most",
                     records.unseen_file->filename().string(), 100.0 * seen.all.rms / seen.output_span,
                     100.0 * seen.all.max / seen.output_span);
}

/// What the record shows, as delays of the controller.
IdentifiedPlant measured_plant(const AxisRecords& records, const controller::Delays& stated, double rate_Hz) {
  try {
    IdentifiedPlant plant = identified_plant(*records.step, stated);
    plant.delays.command_delay = std::chrono::nanoseconds(std::llround(1e9 / rate_Hz));
    return plant;
  } catch (const std::invalid_argument& error) {
    throw Error(fmt::format("{}: {}", records.step_file->string(), error.what()));
  }
}

/// Gains of a cautious loop, which is stable with the measured delays.
controller::LoopConfig cautious_loop(const IdentifiedPlant& plant, double cycle_s) {
  const controller::SensitivityRule rule;
  const auto corners = controller::widened(plant.uncertainty, rule.resonance_percent);
  controller::LoopConfig loop{.delays = plant.delays, .cycle_s = cycle_s};
  loop.pi = controller::largest_gains(loop, corners, controller::CautiousRule{});
  return loop;
}

/// The stated mode within what a statement is good for; above half the rate it may be anything from there up.
controller::PlantUncertainty stated_uncertainty(const controller::Delays& stated, double rate_Hz) {
  constexpr double percent = 10.0;
  controller::PlantUncertainty uncertainty = controller::around(stated, percent);
  uncertainty.damping_ratio.lo /= stated_damping_factor;
  if (uncertainty.resonance_Hz.hi > 0.5 * rate_Hz)
    uncertainty.resonance_Hz.hi = std::numeric_limits<double>::infinity();
  return uncertainty;
}

void set_loop_of(Stage& stage, std::size_t i, controller::LoopConfig loop) {
  loop.delays = in_whole_microseconds(loop.delays);
  set_loop(stage.config.axes[i].control, loop);
  derive(stage.config, i);
}

/// The delays in [axis.control] and in [axis.twin], with the comments that are true of them then.
void set_dynamics(Stage& stage, std::size_t i, const IdentifiedPlant& plant) {
  const controller::Delays delays = in_whole_microseconds(plant.delays);
  set_loop_of(stage, i, cautious_loop(plant, 1.0 / stage.config.controller.rate_Hz));
  twin::AxisConfig& twin = stage.config.axes[i].twin;
  twin.plant.mode.natural_frequency_Hz = delays.resonance_Hz;
  twin.plant.mode.damping_ratio = delays.damping_ratio;
  twin.plant.amplifier.bandwidth_Hz = delays.amplifier_bandwidth_Hz;
  if (delays.sensor_delay.count() > 0) twin.sensor.delay = delays.sensor_delay;
  const std::string axis = fmt::format("axis[{}].", i), in_delays = axis + "control.delays.";
  stage.comments[in_delays + "amplifier_bandwidth_Hz"] = "with the sensor's lag, from the step";
  stage.comments[axis + "twin.bandwidth_Hz"] = "from the step";
  if (!plant.mode) return;
  stage.comments[in_delays + "resonance_Hz"] = "from the step";
  stage.comments[in_delays + "damping_ratio"] = "from the step";
}

std::string dynamics_line(const controller::Delays& delays) {
  return fmt::format("dynamics: {:.5g} Hz, damping ratio {:.3g}, amplifier {:.4g} Hz, sensor {:.3g} ms",
                     delays.resonance_Hz, delays.damping_ratio, delays.amplifier_bandwidth_Hz,
                     1e3 * delays.sensor_s());
}

/// What the record shows, and where that came from.
std::string dynamics_line(const std::string& record, const IdentifiedPlant& plant, double stated_Hz) {
  std::string text = fmt::format("{}; from {}", dynamics_line(plant.delays), record);
  if (!plant.mode)
    text += fmt::format(
        ", which shows delay and lag but no mode ({}): the mode is within what is stated, {:g} Hz, "
        "and the loop is sound with "
        "one anywhere from there up",
        plant.not_shown, stated_Hz);
  else if (!is_as_stated(*plant.mode, stated_Hz))
    text += fmt::format(", where {:g} Hz was stated", stated_Hz);
  if (plant.pure_s > 0.0)
    text += fmt::format("; {:.3g} ms is no lag but a pure delay, taken as the sensor's", 1e3 * plant.pure_s);
  return text;
}

std::string loop_text(const Candidate& best, double resonance_percent) {
  std::string text = fmt::format("kp {:.4g}, ki {:.4g} 1/s", best.loop.pi.kp, best.loop.pi.ki_per_s);
  if (best.loop.measurement_filter_Hz > 0.0)
    text += fmt::format(", low pass {:g} Hz", best.loop.measurement_filter_Hz);
  if (best.loop.notch) text += fmt::format(", notch at {:.5g} Hz", best.loop.notch->frequency_Hz);
  if (best.judged)
    text += fmt::format("; sensitivity at most {:.3g}, {:.3g} with the resonance {:g} % off",
                        best.judged->margins.peak_sensitivity, best.judged->worst.peak_sensitivity,
                        resonance_percent);
  return text;
}

/// The one that is written: the cautious one, where it tracks.
const Candidate& first_proposal(const TuningReport& report) {
  const Candidate& cautious = report.candidates.back();
  return cautious.has_run() ? cautious : report.proposed();
}

std::string loop_line(const TuningReport& report) {
  const Candidate& first = first_proposal(report);
  // The present one has the gains of cautious_loop().
  const bool is_cautious = &first == &report.candidates.back() || &first == &report.present();
  return fmt::format("loop: {}, {}", is_cautious ? "cautious" : first.name,
                     loop_text(first, report.rule.resonance_percent)) +
         (is_cautious
              ? fmt::format("; margins of {:g} degrees and {:.2g} dB", report.cautious_rule.phase_margin_deg,
                            decibel(report.cautious_rule.gain_margin))
              : "; the cautious one does not track");
}

TuningReport tuned_by_step(Stage& stage, std::size_t i, const AxisRecords& records) {
  const std::string name = stage.config.axes[i].wire.name;
  const controller::Delays stated = stage.config.axes[i].control.delays;
  const IdentifiedPlant plant = measured_plant(records, stated, stage.config.controller.rate_Hz);
  set_dynamics(stage, i, plant);
  print_lines(name, {dynamics_line(records.step_file->filename().string(), plant, stated.resonance_Hz)});
  const config::Config config =
      chosen_axis_of(stage.config, {.config = stage.file(), .axis = name, .interface = {}, .rehearse = true});
  TuningReport report = tuning_of(config, usual_steps(config.axes[0].control.gate), false);
  evaluate(report, plant, config, twin_config(stage.config));
  stop_if_signalled();
  if (stated.sensor_s() == 0.0) report.unshared_s = plant.delays.lag_s() + plant.delays.sensor_s();
  set_loop_of(stage, i, first_proposal(report).loop);
  print_lines(name, {loop_line(report)});
  if (const Candidate* fast = faster_of(report))
    print_lines(name,
                {fmt::format("faster: {}, {}", fast->name, loop_text(*fast, report.rule.resonance_percent))});
  if (const auto undrawn =
          draw_response(report, *records.step, stage.file().parent_path() / (name + ".bode.svg")))
    print_lines(name, {"no picture of the loop: " + *undrawn});
  return report;
}

void set_as_stated(Stage& stage, std::size_t i) {
  const config::AxisConfig& axis = stage.config.axes[i];
  const controller::Delays stated = axis.control.delays;
  const double rate_Hz = stage.config.controller.rate_Hz;
  controller::LoopConfig loop{.delays = stated, .cycle_s = 1.0 / rate_Hz};
  loop.pi = controller::unmeasured_gains(loop, stated_uncertainty(stated, rate_Hz));
  set_loop_of(stage, i, loop);
  print_lines(
      axis.wire.name,
      {dynamics_line(stated) + ": stated or assumed, not measured",
       fmt::format("loop: integral alone, ki {:.4g} 1/s: an eighth of what is stable with these; a record of "
                   "small steps (--step) allows more",
                   loop.pi.ki_per_s)});
}

/// The twin with all of the unshared delays in its sensors, or none of them.
twin::Config with_delays_in_sensors(twin::Config twin, const std::vector<TuningReport>& tuned, bool all) {
  for (std::size_t i = 0; i < tuned.size(); ++i)
    if (tuned[i].unshared_s > 0.0) set_delay(twin.axes[i].axis, tuned[i].unshared_s, all);
  return twin;
}

/// The twin with actuators that are as identified.
twin::Config with_exact_models(twin::Config twin, const config::Config& config) {
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    twin::Plant::Config& plant = twin.axes[i].axis.plant;
    plant.hysteresis = config.axes[i].control.law.model;
    plant.hysteresis_creep = config.axes[i].control.law.creep;
    plant.creep.reset();
  }
  return twin;
}

rehearsal::Outcome rehearsed(const config::Config& config, const twin::Config& twin) {
  return rehearsal::run_once(rehearsal_setup(config, twin), settle_s,
                             [](const controller::CycleRecord&) { stop_if_signalled(); });
}

/// The true error of an axis, or why there is none.
std::string true_error_text(const rehearsal::Outcome& outcome, std::size_t i) {
  const controller::ErrorStatistics truth = outcome.true_errors[i].total();
  for (const controller::AxisOutcome& axis : outcome.axes)  // the fault of one axis ends the run of all
    if (axis.fault.cause != controller::Cause::none)
      return fmt::format("a fault ({})", to_string(axis.fault.cause));
  return truth.samples == 0 ? std::string("no sample") : fmt::format("{:.3g} um", truth.rms_um());
}

/// The true errors of each axis where the sensor has all of the unshared delay, or none.
std::vector<std::string> ranges_of(const config::Config& config, const std::vector<TuningReport>& tuned) {
  std::vector<std::string> ranges(tuned.size());
  if (std::ranges::none_of(tuned, [](const TuningReport& of) { return of.unshared_s > 0.0; })) return ranges;
  const twin::Config twin = twin_config(config);
  const rehearsal::Outcome all = rehearsed(config, with_delays_in_sensors(twin, tuned, true)),
                           none = rehearsed(config, with_delays_in_sensors(twin, tuned, false));
  for (std::size_t i = 0; i < tuned.size(); ++i)
    if (tuned[i].unshared_s > 0.0)
      ranges[i] = fmt::format(
          "; {:.3g} ms are taken as the sensor's, which nobody has stated (--sensor-delay): "
          "{} if none are, {} if all {:.3g} ms are",
          1e3 * config.axes[i].control.delays.sensor_s(), true_error_text(none, i), true_error_text(all, i),
          1e3 * tuned[i].unshared_s);
  return ranges;
}

/// The true errors of each axis where a mode that no record shows is as far from the stated one as that may
/// be off.
std::vector<std::string> mode_ranges_of(const config::Config& config,
                                        const std::vector<TuningReport>& tuned) {
  constexpr double share = 0.1;
  std::vector<std::string> ranges(tuned.size());
  if (std::ranges::all_of(tuned, [](const TuningReport& of) { return of.plant.mode.has_value(); }))
    return ranges;
  const auto with_modes = [&](double factor) {
    twin::Config twin = twin_config(config);
    for (std::size_t i = 0; i < tuned.size(); ++i)
      if (!tuned[i].plant.mode) twin.axes[i].axis.plant.mode.natural_frequency_Hz *= factor;
    return rehearsed(config, twin);
  };
  const rehearsal::Outcome lower = with_modes(1.0 - share), higher = with_modes(1.0 + share);
  for (std::size_t i = 0; i < tuned.size(); ++i)
    if (!tuned[i].plant.mode)
      ranges[i] = fmt::format("; {} with the mode, which no record shows, {:g} % lower, {} with it higher",
                              true_error_text(lower, i), 100.0 * share, true_error_text(higher, i));
  return ranges;
}

/// True errors beside what no setpoints can avoid, where that is known.
std::string floors_text(const config::Config& config, std::size_t i,
                        const controller::TrackingStatistics& truth) {
  const config::AxisConfig& axis = config.axes[i];
  const auto floors = tracking_floors_um(axis.twin, axis.control.setpoint, 1.0 / config.controller.rate_Hz);
  std::string text;
  for (std::size_t j = 0; j < floors.size(); ++j)
    if (floors[j])
      text +=
          fmt::format("; of its {} {:.3g} um, of which no setpoints avoid {:.3g}",
                      to_string(axis.control.setpoint[j].shape), truth.segments()[j].rms_um(), *floors[j]);
  return text;
}

}  // namespace

Stage::Stage(std::filesystem::path file, std::string text)
    : config(config::load_text(file, text)),
      file_(std::move(file)),
      read_text_(std::move(text)),
      read_(config) {}

std::string Stage::text() const {
  config::TomlEdit text(read_text_, file_.string());
  edit(text, read_, config);
  for (const auto& [path, comment] : comments) text.set_comment(path, comment);
  return text.text();
}

std::string model_name(const std::string& axis) { return axis + ".model.toml"; }
std::string plant_name(const std::string& axis) { return axis + ".plant.toml"; }

void print_lines(const std::string& of, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) print(fmt::format("{}{}\n", of.empty() ? "" : of + ": ", line));
  flush_output();  // each takes seconds
}

Identified identify_axis(const std::filesystem::path& folder, const std::string& axis,
                         const AxisRecords& records) {
  Identified found = identified_loops(records);
  stop_if_signalled();
  const std::vector<std::string> said = findings(records.loops, found);
  write_file(folder / model_name(axis), identified_model_text(found, said));
  write_file(folder / plant_name(axis),
             "# The twin's actuator: the identified model with curves 3 % and k 20 % off.\n" +
                 config::model_text(not_quite(found.parameters), {}));
  const auto undrawn = write_axis_report(folder / (axis + ".report"), records, found, said);
  stop_if_signalled();
  const double percent = 100.0 / found.output_span;
  print_lines(
      axis,
      {fmt::format(
          "hysteresis: {}, misses {} by {:.3g} % RMS{} of {:.5g} um; {}.report/report.html{}",
          found.search.shape.text(), fmt::join(records.names(), ", "), found.overall.rms * percent,
          found.held_out_rms ? fmt::format(" ({:.3g} % cross-validated)", *found.held_out_rms * percent) : "",
          found.output_span, axis, undrawn ? ", without pictures: " + *undrawn : "")});
  if (records.unseen) print_lines(axis, {validation_line(found.parameters, found.delay_s, records)});
  return found;
}

TuningReport tune_axis(Stage& stage, std::size_t i, const AxisRecords& records) {
  if (records.step) return tuned_by_step(stage, i, records);
  set_as_stated(stage, i);
  return {};
}

const Candidate* faster_of(const TuningReport& report) {
  constexpr double worth_it = 0.98;
  if (report.best == 0) return nullptr;
  const Candidate& fast = report.proposed();
  return fast.rms_percent() < worth_it * first_proposal(report).rms_percent() ? &fast : nullptr;
}

std::vector<std::string> rehearsal_of(const config::Config& config, const std::vector<TuningReport>& tuned) {
  const rehearsal::Outcome outcome = rehearsed(config, twin_config(config));
  std::vector<std::string> lines;
  if (const std::string failure = failure_of(outcome.axes); !failure.empty())
    throw RunError("the rehearsal ended: " + failure);
  const rehearsal::Outcome exact = rehearsed(config, with_exact_models(twin_config(config), config));
  const std::vector<std::string> ranges = ranges_of(config, tuned), modes = mode_ranges_of(config, tuned);
  for (std::size_t i = 0; i < outcome.axes.size(); ++i) {
    const controller::AxisOutcome& axis = outcome.axes[i];
    const controller::ErrorStatistics error = axis.statistics.total(), truth = outcome.true_errors[i].total();
    lines.push_back(
        fmt::format("{}: rehearsal: RMS error {:.3g} um, {:.3g} % of {:.4g} um; at most {:.3g} um", axis.name,
                    error.rms_um(), 100.0 * error.rms_um() / axis.stroke_um, axis.stroke_um, error.max_um));
    lines.push_back(fmt::format(
        "{}: true error, of the stage itself: {:.3g} um, {:.3g} % with curves 3 % off the model, "
        "{} if it is exact{}{}{}",
        axis.name, truth.rms_um(), 100.0 * truth.rms_um() / axis.stroke_um, true_error_text(exact, i),
        modes[i], floors_text(config, i, outcome.true_errors[i]), ranges[i]));
  }
  return lines;
}

}  // namespace hystcan::app
