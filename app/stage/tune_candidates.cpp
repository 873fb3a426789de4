#include "app/stage/tune_candidates.h"

#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "app/live/rehearsal_setup.h"
#include "app/live/report.h"
#include "app/live/stop_signal.h"
#include "base/error.h"
#include "controller/analysis/feed_forward_design.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {
namespace {

constexpr const char* present_name = "present";

/// The loop of a candidate on the identified plant, and what is uncertain about that.
struct PlantOfDesign {
  IdentifiedPlant identified;
  double cycle_s;

  controller::LoopConfig loop(const controller::LoopSetting& setting = {}) const {
    return {.delays = identified.delays,
            .cycle_s = cycle_s,
            .measurement_filter_Hz = setting.measurement_filter_Hz,
            .notch = setting.notch};
  }
};

/// Sets the identified plant in the twin. Its sensor gets the delay that was found; the amplifier's lag takes what its sensor
/// and its way to a setpoint then have not.
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
  axis.law.pi = candidate.setting.pi;
  axis.law.measurement_filter_Hz = candidate.setting.measurement_filter_Hz;
  axis.law.notch = candidate.setting.notch;
  axis.delays = candidate.delays;
  controller::plan_feed_forward(axis, config.controller.rate_Hz);
  axis.learning.reset();  // its filters are designed for the present loop
  set_plant(setup.twin, config.axes[0].wire.name, plant.delays, 1.0 / config.controller.rate_Hz);
  return setup;
}

rehearsal::Outcome outcome_of(const rehearsal::Setup& setup) {
  return rehearsal::run_once(setup, settle_s, [](const controller::CycleRecord&) {
    if (stop_signalled != 0) throw RunError("stopped, nothing is written");
  });
}

/// The present setting is compared with, however little margin it has.
bool may_run(const Candidate& candidate) {
  if (!candidate.loop) return true;
  return candidate.name == present_name ? candidate.loop->margins.stable : candidate.loop->worst.stable;
}

bool is_better(const Candidate& a, const Candidate& b) {
  return a.has_run() && (!b.has_run() || a.rms_percent() < b.rms_percent());
}

const char* name_of(const controller::LoopSetting& setting) {
  if (setting.notch) return "notch";
  return setting.measurement_filter_Hz > 0.0 ? "low pass" : "plain";
}

/// Designs for one identified plant, judged and rehearsed.
class Rehearsed {
 public:
  Rehearsed(const config::Config& config, const twin::Config& twin, const IdentifiedPlant& plant,
            const CandidateRules& rules)
      : config_(config),
        twin_(twin),
        plant_{.identified = plant, .cycle_s = 1.0 / config.controller.rate_Hz},
        corners_(controller::widened(plant_.identified.uncertainty, rules.sensitivity.resonance_percent)) {}

  const PlantOfDesign& plant() const { return plant_; }
  const controller::PlantUncertainty& corners() const { return corners_; }

  Candidate present() const {
    const controller::AxisConfig& axis = config_.axes[0].control;
    const controller::LoopSetting setting{axis.law.pi, axis.law.measurement_filter_Hz, axis.law.notch};
    return predicted(present_name, setting, axis.delays, judged(setting));
  }

  /// With the feed-forward that tracks best.
  Candidate design(const char* name, const controller::LoopSetting& setting) const {
    controller::Delays delays = plant_.identified.delays;
    const std::optional<controller::JudgedLoop> loop = judged(setting);  // no feed-forward is in it
    Candidate best = predicted(name, setting, delays, loop);
    for (const auto& [second_order, plant_inverse] :
         {std::pair(false, false), std::pair(true, false), std::pair(false, true)}) {
      if (second_order == best.delays.second_order && plant_inverse == best.delays.plant_inverse) continue;
      delays.second_order = second_order;
      delays.plant_inverse = plant_inverse;
      Candidate other = predicted(name, setting, delays, loop);
      if (is_better(other, best)) best = std::move(other);
    }
    return best;
  }

 private:
  std::optional<controller::JudgedLoop> judged(const controller::LoopSetting& setting) const {
    if (!(setting.pi.ki_per_s > 0.0)) return std::nullopt;
    return controller::judge(plant_.loop(setting), corners_, setting.pi);
  }

  Candidate predicted(const char* name, const controller::LoopSetting& setting,
                      const controller::Delays& delays,
                      const std::optional<controller::JudgedLoop>& loop) const {
    Candidate candidate{.name = name, .setting = setting, .delays = delays};
    candidate.loop = loop;
    if (!may_run(candidate)) return candidate;
    rehearsal::Outcome outcome = outcome_of(setup_of(candidate, config_, twin_, plant_.identified));
    candidate.predicted = std::move(outcome.axes[0]);
    candidate.true_rms_um = outcome.true_errors[0].total().rms_um();
    return candidate;
  }

  const config::Config& config_;
  const twin::Config& twin_;
  PlantOfDesign plant_;
  controller::PlantUncertainty corners_;
};

}  // namespace

std::vector<Candidate> rehearsed_candidates(const config::Config& config, const twin::Config& twin,
                                            const IdentifiedPlant& identified, const CandidateRules& rules) {
  const Rehearsed rehearsed(config, twin, identified, rules);
  const PlantOfDesign& plant = rehearsed.plant();
  std::vector<Candidate> candidates{rehearsed.present()};
  if (!rules.only_cautious)
    for (const controller::LoopSetting& setting :
         controller::designs(plant.loop(), plant.identified.uncertainty, rules.sensitivity))
      candidates.push_back(rehearsed.design(name_of(setting), setting));
  candidates.push_back(rehearsed.design(
      "cautious", {.pi = controller::largest_gains(plant.loop(), rehearsed.corners(), rules.cautious)}));
  return candidates;
}

void predict_structures(Candidate& candidate, const config::Config& config, const twin::Config& twin,
                        const IdentifiedPlant& plant) {
  if (!may_run(candidate)) return;
  for (const controller::Structure structure : controller::all_structures)
    candidate.by_structure.push_back(std::move(
        outcome_of(rehearsal::with_structure(setup_of(candidate, config, twin, plant), structure)).axes[0]));
}

void set_delay(twin::AxisConfig& axis, double delay_s, bool is_the_sensors) {
  constexpr double without_lag_Hz = 1e5;
  axis.sensor.delay = std::chrono::nanoseconds(std::llround(is_the_sensors ? 1e9 * delay_s : 0.0));
  axis.plant.amplifier.bandwidth_Hz =
      is_the_sensors ? without_lag_Hz : 1.0 / (2.0 * std::numbers::pi * delay_s);
}

std::optional<DelayShares> delay_shares(const Candidate& candidate, const config::Config& config,
                                        const twin::Config& twin, const IdentifiedPlant& plant) {
  const double delay_s = plant.delays.lag_s() + plant.delays.sensor_s();
  if (config.axes[0].control.delays.sensor_s() > 0.0 || !(delay_s > 0.0)) return std::nullopt;
  const auto true_um = [&](bool is_the_sensors) -> std::optional<double> {
    rehearsal::Setup setup = setup_of(candidate, config, twin, plant);
    for (twin::WiredAxisConfig& axis : setup.twin.axes)
      if (axis.wire.name == config.axes[0].wire.name) set_delay(axis.axis, delay_s, is_the_sensors);
    const rehearsal::Outcome outcome = outcome_of(setup);
    if (outcome.axes[0].fault.cause != controller::Cause::none) return std::nullopt;
    return outcome.true_errors[0].total().rms_um();
  };
  return DelayShares{.delay_s = delay_s, .all_um = true_um(true), .none_um = true_um(false)};
}

}  // namespace hystcan::app
