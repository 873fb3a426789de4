#include "app/stage/tuning.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "app/live/rehearsal_setup.h"
#include "app/live/report.h"
#include "app/live/stop_signal.h"
#include "app/stage/config_edit.h"
#include "base/error.h"
#include "base/standard_streams.h"
#include "controller/analysis/feed_forward_design.h"
#include "controller/excitation_dataset.h"
#include "identification/characterisation.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {
namespace {

using controller::Excitation;
using identification::Dataset;

constexpr const char* present_name = "present";

/// Sets the identified dynamics in the twin of one axis. The twin's sensor gets the identified sensor delay.
/// The lag of the twin's amplifier is set so that the twin has the identified total delay: the other parts of
/// this delay come from mode and sensor, and from the amplifier's interpolation between setpoints.
void set_plant(twin::Config& twin, const std::string& axis_name, const controller::Delays& found,
               double cycle_s) {
  for (twin::WiredAxisConfig& axis : twin.axes) {
    if (axis.wire.name != axis_name) continue;
    twin::Plant::Config& plant = axis.axis.plant;
    if (found.sensor_delay.count() > 0) axis.axis.sensor.delay = found.sensor_delay;
    const controller::Delays own{.amplifier_bandwidth_Hz = found.amplifier_bandwidth_Hz,
                                 .resonance_Hz = found.resonance_Hz,
                                 .damping_ratio = found.damping_ratio,
                                 .interpolated = axis.axis.interpolate,
                                 .sensor_delay = axis.axis.sensor.delay,
                                 .sensor_bandwidth_Hz = axis.axis.sensor.bandwidth_Hz};
    const auto without_commands = [&](const controller::Delays& of) {
      return of.preview_s(cycle_s) - std::chrono::duration<double>(of.command_delay).count() + of.sensor_s();
    };
    plant.mode.natural_frequency_Hz = found.resonance_Hz;
    plant.mode.damping_ratio = found.damping_ratio;
    const double rest_s = found.lag_s() + without_commands(found) - without_commands(own);
    if (rest_s > 0.0) plant.amplifier.bandwidth_Hz = 1.0 / (2.0 * std::numbers::pi * rest_s);
  }
}

rehearsal::Setup setup_of(const Candidate& candidate, const config::Config& config, const twin::Config& twin,
                          const IdentifiedPlant& plant) {
  rehearsal::Setup setup = rehearsal_setup(config, twin);
  controller::AxisConfig& axis = setup.controller.axes[0].axis;
  set_loop(axis, candidate.loop);
  controller::plan_feed_forward(axis, config.controller.rate_Hz);
  axis.learning.reset();  // off, because the filters of learning were designed for the present loop
  set_plant(setup.twin, config.axes[0].wire.name, plant.delays, 1.0 / config.controller.rate_Hz);
  return setup;
}

rehearsal::Outcome outcome_of(const rehearsal::Setup& setup) {
  return rehearsal::run_once(setup, settle_s, [](const controller::CycleRecord&) { throw_if_signalled(); });
}

/// Returns true if the candidate is stable enough for a rehearsal. A new design must be stable at every
/// corner of the plant's uncertainty (a combination of the ends of its intervals). The present setting is
/// always needed for comparison, so it must be stable only with the identified plant.
bool may_run(const Candidate& candidate) {
  if (!candidate.judged) return true;
  return candidate.name == present_name ? candidate.judged->margins.stable : candidate.judged->worst.stable;
}

bool is_better(const Candidate& a, const Candidate& b) {
  return a.has_run() && (!b.has_run() || a.rms_percent() < b.rms_percent());
}

const char* name_of(const controller::LoopConfig& loop) {
  if (loop.notch) return "notch";
  return loop.measurement_filter_Hz > 0.0 ? "low pass" : "plain";
}

/// Designs loops for the identified plant, judges their stability, and rehearses them.
class Rehearsed {
 public:
  Rehearsed(const TuningReport& report, const config::Config& config, const twin::Config& twin)
      : report_(report),
        config_(config),
        twin_(twin),
        corners_(controller::widened(report.plant.uncertainty, report.rule.resonance_percent)) {}

  std::vector<Candidate> candidates() const {
    const controller::AxisConfig& axis = config_.axes[0].control;
    const double cycle_s = 1.0 / config_.controller.rate_Hz;
    std::vector<Candidate> all{
        predicted(present_name, controller::loop_config_of(axis.law, axis.delays, cycle_s))};
    controller::LoopConfig plain{.delays = report_.plant.delays, .cycle_s = cycle_s};
    if (!report_.only_cautious)
      for (const controller::LoopConfig& loop :
           controller::designs(plain, report_.plant.uncertainty, report_.rule))
        all.push_back(design(name_of(loop), loop));
    plain.pi = controller::largest_gains(plain, corners_, report_.cautious_rule);
    all.push_back(design("cautious", plain));
    return all;
  }

 private:
  /// Returns the design as a candidate, with the feed-forward that has the smallest error in a rehearsal.
  Candidate design(const char* name, controller::LoopConfig loop) const {
    Candidate best = predicted(name, loop);
    for (const auto& [second_order, plant_inverse] : feed_forwards) {
      const controller::Delays& tried = best.loop.delays;
      if (second_order == tried.second_order && plant_inverse == tried.plant_inverse) continue;
      loop.delays.second_order = second_order;
      loop.delays.plant_inverse = plant_inverse;
      Candidate other = predicted(name, loop);
      if (is_better(other, best)) best = std::move(other);
    }
    return best;
  }

  /// Returns the margins of the loop with the identified plant; `nullopt` if the loop has no integral gain.
  std::optional<controller::JudgedLoop> judged(controller::LoopConfig loop) const {
    if (!(loop.pi.ki_per_s > 0.0)) return std::nullopt;
    loop.delays = report_.plant.delays;
    return controller::judge(loop, corners_);
  }

  Candidate predicted(const char* name, const controller::LoopConfig& loop) const {
    Candidate candidate{.name = name, .loop = loop, .judged = judged(loop)};
    if (!may_run(candidate)) return candidate;
    rehearsal::Outcome outcome = outcome_of(setup_of(candidate, config_, twin_, report_.plant));
    candidate.predicted = std::move(outcome.axes[0]);
    candidate.true_rms_um = outcome.true_errors[0].total().rms_um();
    return candidate;
  }

  const TuningReport& report_;
  const config::Config& config_;
  const twin::Config& twin_;
  controller::PlantUncertainty corners_;
};

void predict_structures(Candidate& candidate, const config::Config& config, const twin::Config& twin,
                        const IdentifiedPlant& plant) {
  if (!may_run(candidate)) return;
  for (const controller::Structure structure : controller::all_structures)
    candidate.by_structure.push_back(std::move(
        outcome_of(rehearsal::with_structure(setup_of(candidate, config, twin, plant), structure)).axes[0]));
}

/// Returns the configuration at another cycle rate, with a cautious loop for this rate and with the
/// identified plant in the twin.
config::Config at_rate(const TuningReport& report, config::Config config, double rate_Hz) {
  config.controller.rate_Hz = rate_Hz;
  controller::LoopConfig loop =
      cautious_loop(report.plant, rate_Hz, report.rule.resonance_percent, report.cautious_rule);
  loop.delays = in_whole_microseconds(loop.delays);
  config::AxisConfig& axis = config.axes[0];
  set_loop(axis.control, loop);
  axis.control.learning.reset();
  controller::plan_feed_forward(axis.control, rate_Hz);
  twin::Config twin = twin_config(config);
  set_plant(twin, axis.wire.name, report.plant.delays, 1.0 / rate_Hz);
  axis.twin = twin.axes.front().axis;
  return config;
}

}  // namespace

/// The time of a row in the dataset is the number of cycles since the first row, including cycles that the
/// controller missed, times the nominal cycle time. The measured times are not used: sample and drive both
/// follow the SYNC, so its jitter of some microseconds does not affect the identified mode.
Dataset measured_steps(const config::Config& config, const twin::Config& twin, const OpenLoopOptions& run,
                       const Excitation::Steps& steps) {
  const config::AxisConfig& axis = config.axes[0];
  const double rate_Hz = config.controller.rate_Hz;
  Dataset record{
      .input_unit = axis.wire.drive_unit, .output_unit = "um", .time_s = {}, .input = {}, .output = {}};
  controller::ExcitationDataset rows;
  std::uint64_t first = 0;
  const OpenLoopEnd end =
      drive_in_open_loop(in_open_loop(config, steps), twin, run, [&](const controller::CycleRecord& cycle) {
        const auto row = rows.add(cycle);
        if (!row) return;
        const std::uint64_t number = cycle.cycle + cycle.counters.missed_cycles;
        if (record.time_s.empty()) first = number;
        record.time_s.push_back(static_cast<double>(number - first) / rate_Hz);
        record.input.push_back(row->input);
        record.output.push_back(row->output);
      });
  for (const std::string& text : end.closing) note("{}\n", text);
  end.require_finished(axis.wire.name, "stopped before the end of the experiment; nothing is written");
  return record;
}

TuningReport tuning_of(const config::Config& config) {
  const config::AxisConfig& axis = config.axes[0];
  TuningReport report;
  report.config = config.file.filename().string();
  report.axis = axis.wire.name;
  report.drive_unit = axis.wire.drive_unit;
  report.actuator = axis.twin_model.string();
  report.rate_Hz = config.controller.rate_Hz;
  return report;
}

IdentifiedPlant plant_of_steps(const Dataset& record, const config::Config& config) {
  try {
    return identified_plant(record, config.axes[0].control.delays);
  } catch (const identification::OutputFalls& error) {
    throw RunError(config.axes[0].wire.name, error, {.remedy = "nothing is written"});
  } catch (const std::invalid_argument& error) {
    throw RunError(
        "the experiment is not conclusive", error,
        {.remedy = "try another --amplitude: the hysteresis loop bends the response to a large step, "
                   "and noise hides the response to a small step. Nothing is written"});
  }
}

controller::LoopConfig cautious_loop(const IdentifiedPlant& plant, double rate_Hz, double resonance_percent,
                                     const controller::CautiousRule& rule) {
  controller::LoopConfig loop{.delays = plant.delays, .cycle_s = 1.0 / rate_Hz};
  loop.delays.command_delay = std::chrono::nanoseconds(std::llround(1e9 / rate_Hz));
  loop.pi = controller::largest_gains(loop, controller::widened(plant.uncertainty, resonance_percent), rule);
  return loop;
}

void evaluate(TuningReport& report, const IdentifiedPlant& plant, const config::Config& config,
              const twin::Config& twin) {
  report.plant = plant;
  report.plant.delays.command_delay = std::chrono::nanoseconds(std::llround(1e9 / report.rate_Hz));
  stop_at_a_signal();
  report.candidates = Rehearsed(report, config, twin).candidates();
  report.best = best_of(report.candidates, report.only_cautious ? std::numeric_limits<double>::infinity()
                                                                : report.rule.peak_sensitivity);
  if (report.proposed().has_run()) return;
  const Candidate& last = report.candidates.back();
  const std::string ended = last.predicted ? failure_of({*last.predicted}) : "the loop is not stable";
  const bool is_short = last.predicted && last.predicted->fault.cause == controller::Cause::none &&
                        last.predicted->state == controller::AxisState::tracking;
  throw RunError(fmt::format(
      "no candidate tracks the configured reference in the rehearsal, {}: {}. {}", last.name, ended,
      is_short ? "[[axis.control.setpoint]] ends before an error can be measured: make the reference longer"
               : "Check the limits in [axis.control] and the stage in [axis.twin]; "
                 "`hystcan demo` shows the run without the following-error limit"));
}

void predict_further(TuningReport& report, const config::Config& config, const twin::Config& twin) {
  predict_structures(report.candidates[0], config, twin, report.plant);
  if (report.best > 0) predict_structures(report.candidates[report.best], config, twin, report.plant);
  if (config.axes[0].control.delays.sensor_s() == 0.0)
    report.unshared_s = report.plant.delays.lag_s() + report.plant.delays.sensor_s();
  report.promise = promises_of(setup_of(report.proposed(), config, twin, report.plant),
                               {basis_of(config, 0, report.proposed().name, uncertainty_of(report))})
                       .front();
  const ConfigAtRate other = [&](double rate_Hz) { return at_rate(report, config, rate_Hz); };
  report.offer = better_rate(other, rates_to_try(other(report.rate_Hz)), {*report.promise});
}

std::vector<std::optional<double>> tracking_floors_um(const twin::AxisConfig& stage,
                                                      const std::vector<controller::Segment>& setpoint,
                                                      double cycle_s) {
  const controller::Delays chain{.amplifier_bandwidth_Hz = stage.plant.amplifier.bandwidth_Hz,
                                 .resonance_Hz = stage.plant.mode.natural_frequency_Hz,
                                 .damping_ratio = stage.plant.mode.damping_ratio,
                                 .interpolated = stage.interpolate};
  std::vector<std::optional<double>> floors;
  floors.reserve(setpoint.size());
  for (const controller::Segment& segment : setpoint)
    floors.push_back(stage.plant.second_mode ? std::nullopt
                                             : controller::tracking_floor_um(chain, cycle_s, segment.shape));
  return floors;
}

}  // namespace hystcan::app
