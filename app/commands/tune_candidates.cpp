#include "app/commands/tune_candidates.h"

#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "app/io/exit_status.h"
#include "app/live/rehearsal_setup.h"
#include "app/live/stop_signal.h"
#include "app/report/dynamics_text.h"
#include "app/report/report.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {
namespace {

using identification::SecondOrderFit;

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

/// Sets the identified mode in the twin. The amplifier's lag represents the part of the delay that is not the twin's
/// sensor's.
void set_mode(twin::Config& twin, const std::string& axis_name, const SecondOrderFit& found) {
  for (twin::WiredAxisConfig& axis : twin.axes) {
    if (axis.wire.name != axis_name) continue;
    twin::Plant::Config& plant = axis.axis.plant;
    const twin::Sensor::Config& sensor = axis.axis.sensor;
    double sensor_s = std::chrono::duration<double>(sensor.delay).count();
    if (sensor.bandwidth_Hz > 0.0) sensor_s += 1.0 / (2.0 * std::numbers::pi * sensor.bandwidth_Hz);
    plant.mode = found.mode();
    plant.amplifier.bandwidth_Hz =
        bandwidth_Hz_for(later(found.delay_s, -sensor_s)).value_or(plant.amplifier.bandwidth_Hz);
  }
}

rehearsal::Setup setup_of(const Candidate& candidate, const config::Config& config, const twin::Config& twin,
                          const SecondOrderFit& fit) {
  rehearsal::Setup setup = rehearsal_setup(config, twin);
  controller::AxisConfig& axis = setup.controller.axes[0].axis;
  axis.law.pi = candidate.setting.pi;
  axis.law.measurement_filter_Hz = candidate.setting.measurement_filter_Hz;
  axis.law.notch = candidate.setting.notch;
  axis.delays = candidate.delays;
  axis.learning.reset();  // its filters are designed for the present loop
  set_mode(setup.twin, config.axes[0].wire.name, fit);
  return setup;
}

rehearsal::Outcome outcome_of(const rehearsal::Setup& setup) {
  return rehearsal::run_once(setup, settle_s, [](const controller::CycleRecord&) {
    if (stop_signalled != 0) throw RunError("stopped, nothing is written");
  });
}

bool may_run(const Candidate& candidate) { return !candidate.loop || candidate.loop->worst.stable; }

bool is_better(const Candidate& a, const Candidate& b) {
  return a.has_run() && (!b.has_run() || a.rms_percent() < b.rms_percent());
}

const char* name_of(const controller::LoopSetting& setting) {
  if (setting.notch) return "notch";
  return setting.measurement_filter_Hz > 0.0 ? "low pass" : "plain";
}

}  // namespace

IdentifiedPlant identified_plant(const config::Config& config, const SecondOrderFit& fit) {
  IdentifiedPlant plant = plant_of(fit, config.axes[0].control.delays);
  plant.delays.command_delay = std::chrono::nanoseconds(std::llround(1e9 / config.controller.rate_Hz));
  return plant;
}

namespace {

/// Designs for one identified plant, judged and rehearsed.
class Rehearsed {
 public:
  Rehearsed(const config::Config& config, const twin::Config& twin, const SecondOrderFit& fit,
            const CandidateRules& rules)
      : config_(config),
        twin_(twin),
        fit_(fit),
        plant_{.identified = identified_plant(config, fit), .cycle_s = 1.0 / config.controller.rate_Hz},
        corners_(controller::widened(plant_.identified.uncertainty, rules.sensitivity.resonance_percent)) {}

  const PlantOfDesign& plant() const { return plant_; }

  Candidate present() const {
    const controller::AxisConfig& axis = config_.axes[0].control;
    return predicted("present", {axis.law.pi, axis.law.measurement_filter_Hz, axis.law.notch}, axis.delays);
  }

  /// With the delays compensated to the first or to the second order.
  Candidate design(const char* name, const controller::LoopSetting& setting) const {
    controller::Delays delays = plant_.identified.delays;
    Candidate configured = predicted(name, setting, delays);
    delays.second_order = !delays.second_order;
    Candidate other = predicted(name, setting, delays);
    return is_better(other, configured) ? other : configured;
  }

 private:
  Candidate predicted(const char* name, const controller::LoopSetting& setting,
                      const controller::Delays& delays) const {
    Candidate candidate{.name = name, .setting = setting, .delays = delays};
    if (setting.pi.ki_per_s > 0.0)
      candidate.loop = controller::judge(plant_.loop(setting), corners_, setting.pi);
    if (!may_run(candidate)) return candidate;
    rehearsal::Outcome outcome = outcome_of(setup_of(candidate, config_, twin_, fit_));
    candidate.predicted = std::move(outcome.axes[0]);
    // With more axes in the twin, its first one need not be this one.
    if (twin_.axes.size() == 1) candidate.true_rms_um = outcome.true_errors[0].total().rms_um();
    return candidate;
  }

  const config::Config& config_;
  const twin::Config& twin_;
  const SecondOrderFit& fit_;
  PlantOfDesign plant_;
  controller::PlantUncertainty corners_;
};

}  // namespace

std::vector<Candidate> rehearsed_candidates(const config::Config& config, const twin::Config& twin,
                                            const SecondOrderFit& fit, const CandidateRules& rules) {
  const Rehearsed rehearsed(config, twin, fit, rules);
  const PlantOfDesign& plant = rehearsed.plant();
  std::vector<Candidate> candidates{rehearsed.present()};
  if (!rules.only_cautious)
    for (const controller::LoopSetting& setting :
         controller::designs(plant.loop(), plant.identified.uncertainty, rules.sensitivity))
      candidates.push_back(rehearsed.design(name_of(setting), setting));
  candidates.push_back(
      rehearsed.design("cautious", {.pi = controller::largest_gains(plant.loop(), rules.cautious)}));
  return candidates;
}

void predict_structures(Candidate& candidate, const config::Config& config, const twin::Config& twin,
                        const SecondOrderFit& fit) {
  if (!may_run(candidate)) return;
  for (const controller::Structure structure : controller::all_structures)
    candidate.by_structure.push_back(std::move(
        outcome_of(rehearsal::with_structure(setup_of(candidate, config, twin, fit), structure)).axes[0]));
}

}  // namespace hystcan::app
