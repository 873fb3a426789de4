#include "controller/control/axis_config.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace hystcan::controller {
namespace {

/// The ringing of a mode decays in three time constants. With a very small configured damping, three time
/// constants would be too long, so the time is limited to two seconds.
constexpr double decays = 3.0, longest_decay_s = 2.0;

/// Shares by which a stage may be less steep than its model. A straight line as a model gives only the
/// direction and the order of magnitude of a stage's motion: the flat end of a loop can be a third as steep
/// as its mean. In open loop, shortfall_of_a_line applies to every model, because a run in open loop often
/// serves to replace an old model.
constexpr double shortfall_of_a_line = 0.9, shortfall_of_a_measured_model = 0.3;

bool is_line(const model::HysteresisParameters& model) {
  constexpr double share = 1e-3;
  const model::Interval& drives = model.input_range();
  const double middle_um = 0.5 * (model.ascending.value(drives.lo) + model.ascending.value(drives.hi));
  const double at_middle = 0.5 * (drives.lo + drives.hi);
  const double allowed_um = share * model.output_range().span();
  return std::abs(model.ascending.value(at_middle) - middle_um) < allowed_um &&
         std::abs(model.descending.value(at_middle) - middle_um) < allowed_um;
}

/// True if PI can make an oscillation of the mode grow. The test assumes an eighth of the configured damping
/// of the mode, because the real damping can be lower than the configured one. If the result is false, PI is
/// too weak, and only the reference can cause an oscillation.
bool can_oscillate(const PiGains& pi, const Delays& delays) {
  const double integral = pi.ki_per_s / (2.0 * std::numbers::pi * delays.resonance_Hz);
  return 8.0 * std::hypot(pi.kp, integral) > 2.0 * delays.damping_ratio;
}

}  // namespace

model::Interval reach_of(const AxisConfig& config) {
  const model::Interval plausible{config.supervision.position_min_um, config.supervision.position_max_um};
  if (config.excitation) return plausible;
  const model::Interval reach = model_reach_um(config.law.model, config.gate);
  return {std::max(plausible.lo, reach.lo), std::min(plausible.hi, reach.hi)};
}

Supervisor::Config supervision_of(const AxisConfig& config) {
  Supervisor::Config supervision = config.supervision;
  supervision.drive_range = config.gate.drive_max - config.gate.drive_min;
  supervision.enable_timeout_s += std::chrono::duration<double>(config.enable_delay).count();
  return supervision;
}

OutputCheck output_check_of(const AxisConfig& config) {
  return {config.gate.drive_max - config.gate.drive_min, config.delays.lag_s()};
}

RampCheck::Config ramp_check_of(const AxisConfig& config) {
  const model::HysteresisParameters& model = config.law.model;
  const double stroke_um = model.output_range().span();
  const double um_per_s = config.wipe_slew_per_s * stroke_um / model.input_range().span();
  const double omega = 2.0 * std::numbers::pi * config.delays.resonance_Hz;
  const bool is_measured = !config.excitation && !is_line(model);
  return {.drive_range = config.gate.drive_max - config.gate.drive_min,
          .stroke_um = stroke_um,
          .ramp_um_per_s = um_per_s,
          .mode_rad_per_s = omega,
          .decay_s = std::min(longest_decay_s, decays / (config.delays.damping_ratio * omega)),
          .slope_shortfall = is_measured ? shortfall_of_a_measured_model : shortfall_of_a_line};
}

model::Interval model_drives(const model::HysteresisParameters& model, const Gate::Config& gate) {
  const model::Interval& thresholds = model.input_range();
  return {std::max(thresholds.lo, gate.drive_min), std::min(thresholds.hi, gate.drive_max)};
}

model::Interval model_reach_um(const model::HysteresisParameters& model, const Gate::Config& gate) {
  const model::Interval drives = model_drives(model, gate);
  return model.outputs(model.descending.value(drives.lo), model.ascending.value(drives.hi));
}

ReferenceLimits default_transition_limits(const Gate::Config& gate, const model::HysteresisParameters& model,
                                          const Delays& delays) {
  constexpr double share_of_gate = 0.5;
  constexpr double share_of_stroke = 1e-3;
  const model::Interval& thresholds = model.ascending.domain();
  const double stroke_um = model.output_range().span();
  const double omega = 2.0 * std::numbers::pi * delays.resonance_Hz;
  return {.slew_um_per_s = share_of_gate * gate.slew_per_s * stroke_um / thresholds.span(),
          .acceleration_um_per_s2 = share_of_stroke * omega * omega * stroke_um};
}

double oscillation_amplitude_um(const AxisConfig& config) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const ControlLaw::Config& law = config.law;
  if (config.excitation || !feeds_back(law.structure) || !can_oscillate(law.pi, config.delays))
    return infinite;
  const Supervisor::Config& limits = config.supervision;
  const double jump_um = limits.position_jump_um > 0.0 ? limits.position_jump_um : infinite;
  return std::min({config.following_error.error_um / 2.0, jump_um / 3.0,
                   (limits.position_max_um - limits.position_min_um) / 20.0});
}

TransitionLimits transition_limits_of(const AxisConfig& config) {
  return {.motion = config.transition_limits, .range = reach_of(config)};
}

Trajectory reference_of(const AxisConfig& config) {
  return {config.setpoint, config.repeat, config.reference_limits, transition_limits_of(config)};
}

}  // namespace hystcan::controller
