#include "controller/control/law.h"

#include <algorithm>
#include <cmath>

#include "model/hysteresis_parameters.h"

namespace hystcan::controller {
namespace {

/// Tolerance in um: if the limits of the drive removed less than this from the demanded position, the demand
/// counts as met. The value is far below the resolution of any sensor and far above rounding.
constexpr double met_within_um = 1e-6;

/// After a change to a structure without PI, the integral decays. Below this value in um it counts as zero.
/// The value is less than the resolution of a position on the wire.
constexpr double faded_um = 1e-7;

/// Capacity of the memory of a model without hysteresis, which never uses its memory.
constexpr std::size_t least_capacity = 4;

}  // namespace

ControlLaw::ControlLaw(const Config& config)
    : config_(config),
      full_(config.model),
      average_(model::average(config.model)),
      line_(model::straight_line(config.model)),
      memory_(full_.at_lower_threshold()),
      average_rest_(average_.at_lower_threshold(least_capacity)),
      line_rest_(line_.at_lower_threshold(least_capacity)),
      creep_(config.creep),
      creep_state_(creep_.settled(memory_.output)) {}

const model::Hysteresis& ControlLaw::inverted() const {
  switch (config_.structure) {
    case Structure::average:
    case Structure::average_pi:
      return average_;
    case Structure::pi:
      return line_;
    case Structure::inverse:
    case Structure::inverse_pi:
      break;
  }
  return full_;
}

const model::HysteresisState& ControlLaw::inverted_memory() const {
  const model::Hysteresis* inverted = &this->inverted();
  return inverted == &full_ ? memory_ : inverted == &line_ ? line_rest_ : average_rest_;
}

double ControlLaw::predicted_um() const {
  const bool is_full = &inverted() == &full_;
  const double at_once_um =
      is_full ? memory_.output : inverted().forward(inverted_memory(), memory_.input).value;
  return creep_.output(creep_state_, at_once_um);
}

double ControlLaw::restart(double position_um) {
  const double reference_um = feeds_back() ? position_um : predicted_um();
  previewed_um_ = reference_um;
  filtered_um_ = error_um_ = integrated_s_ = 0.0;
  before_notch_um_ = demand_um_ = predicted_um();
  notch_state_ = Notch::at_rest(before_notch_um_);
  integral_um_ = before_notch_um_ - feed_forward_um();
  return reference_um;
}

void ControlLaw::retune(const Config& config) {
  const bool another_structure = config.structure != config_.structure;
  const double proportional_before_um = proportional_um();
  config_.structure = config.structure;
  config_.pi = config.pi;
  config_.deadband_um = config.deadband_um;
  config_.measurement_filter_Hz = config.measurement_filter_Hz;
  config_.notch = config.notch;
  notch_for_s_ = 0.0;
  error_um_ = outside_deadband(filtered_um_, config_.deadband_um);
  if (another_structure)
    enter_structure();
  else
    integral_um_ += proportional_before_um - proportional_um();
}

// Called after `config_.structure` has changed: the law may now invert another model. Prevents a jump of the
// drive: the next demanded position becomes the output of the newly inverted model at the last applied drive.
// The state of the notch is shifted by the same amount, so that the notch keeps its transient.
void ControlLaw::enter_structure() {
  const double moved_um = predicted_um() - demand_um_;
  Notch::shift(notch_state_, moved_um);
  demand_um_ += moved_um;
  before_notch_um_ += moved_um;
  integral_um_ = before_notch_um_ - feed_forward_um() - proportional_um();
}

ControlLaw::Demand ControlLaw::propose(const Input& input) {
  previewed_um_ = input.previewed_um;
  update_error(input);
  integrate(input.dt_s);
  before_notch_um_ = feed_forward_um() + proportional_um() + integral_um_;
  demand_um_ = notched(before_notch_um_, input.cycle_s);

  const double at_once_um = creep_.inverse(creep_state_, demand_um_);
  const model::FoundInput drive = inverted().inverse(inverted_memory(), at_once_um);
  if (&inverted() == &full_ && drive.near.slope > 0.0) memory_.near = drive.near;
  Demand demand{.drive = drive.value, .position_um = demand_um_};
  if (drive.saturated) demand.limits |= limit::model;
  if (!drive.increasing) demand.limits |= limit::not_invertible;
  return demand;
}

// The low pass filters the error, so it delays reference and measurement equally and causes no error. Omitted
// cycles and cycles without a sample do not add to the integral: the error during these cycles is not known.
void ControlLaw::update_error(const Input& input) {
  const double elapsed_s = input.cycle_s > 0.0 ? std::min(input.dt_s, input.cycle_s) : input.dt_s;
  integrated_s_ = input.position_um ? elapsed_s : 0.0;
  if (!input.position_um) return;
  const double error_um = input.reference_um - *input.position_um;
  const double corner_Hz = config_.measurement_filter_Hz;
  filtered_um_ = corner_Hz > 0.0 ? low_pass(corner_Hz, filtered_um_, error_um, input.dt_s) : error_um;
  error_um_ = outside_deadband(filtered_um_, config_.deadband_um);
}

void ControlLaw::integrate(double dt_s) {
  integral_before_um_ = integral_um_;
  if (feeds_back())
    integral_um_ += config_.pi.ki_per_s * error_um_ * integrated_s_;
  else
    integral_um_ =
        std::abs(integral_before_um_) > faded_um ? integral_before_um_ * std::exp(-dt_s / fade_s) : 0.0;
}

double ControlLaw::notched(double before_um, double cycle_s) {
  if (!config_.notch) return Notch::pass(notch_state_, before_um);
  if (cycle_s != notch_for_s_) {
    notch_ = Notch::design(*config_.notch, cycle_s);
    notch_for_s_ = cycle_s;
  }
  return Notch::step(notch_, notch_state_, before_um);
}

void ControlLaw::commit(double applied_drive) {
  follow(applied_drive);
  if (!feeds_back() || integrated_s_ == 0.0) return;
  const double excess_um = demand_um_ - predicted_um();
  if (std::abs(excess_um) > met_within_um) prevent_windup(excess_um);
}

void ControlLaw::prevent_windup(double excess_um) {
  const auto& [kp, ki_per_s] = config_.pi;
  if (feeds_forward() && (feed_forward_um() - predicted_um()) * excess_um > 0.0) {
    if (excess_um * error_um_ > 0.0) integral_um_ = integral_before_um_;
  } else if (ki_per_s > 0.0) {
    integral_um_ -= (kp > 0.0 ? -std::expm1(-ki_per_s * integrated_s_ / kp) : 1.0) * excess_um;
  }
}

}  // namespace hystcan::controller
