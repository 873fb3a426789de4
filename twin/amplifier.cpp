#include "twin/amplifier.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hystcan::twin {
namespace {

/// v' = rate (pole - v); `decay` is e^{-rate dt} of the whole step.
struct Line {
  double rate_per_s;
  double pole;
  double decay;

  double after(double v) const { return pole - (pole - v) * decay; }
  double after(double v, double t_s) const { return pole - (pole - v) * std::exp(-rate_per_s * t_s); }
  /// v above which v' is less than `slew_per_s`.
  double slower_from(double slew_per_s) const { return pole - slew_per_s / rate_per_s; }
};

/// v above which the steeper line is below the flatter one; infinite: the flatter one ends before.
double crossing(const Line& flat, const Line& steep) {
  if (steep.pole >= flat.pole) return Amplifier::unlimited;
  return (steep.rate_per_s * steep.pole - flat.rate_per_s * flat.pole) / (steep.rate_per_s - flat.rate_per_s);
}

/// v after `dt_s` of v' = min(slew, a, b), v below both poles.
double rise(double v, double slew_per_s, const Line& a, const Line& b, double dt_s) {
  const auto& [flat, steep] =
      std::minmax(a, b, [](const Line& one, const Line& other) { return one.rate_per_s < other.rate_per_s; });
  double left_s = dt_s;
  if (const double end = std::min(flat.slower_from(slew_per_s), steep.slower_from(slew_per_s)); v < end) {
    const double slewing_s = (end - v) / slew_per_s;
    if (left_s <= slewing_s) return v + slew_per_s * left_s;
    left_s -= slewing_s;
    v = end;
  }
  if (const double end = crossing(flat, steep); v < end) {
    const double until_s =
        std::isinf(end) ? end : std::log((flat.pole - v) / (flat.pole - end)) / flat.rate_per_s;
    if (left_s <= until_s) return left_s == dt_s ? flat.after(v) : flat.after(v, left_s);
    left_s -= until_s;
    v = end;
  }
  return left_s == dt_s ? steep.after(v) : steep.after(v, left_s);
}

double slew_into_the_load(const Amplifier::Config& config) {
  double slew_per_s = config.slew_per_s;
  if (config.load_uF > 0.0)
    slew_per_s = std::min(slew_per_s, config.current_limit_A / (1e-6 * config.load_uF));
  if (config.load_mH > 0.0 && config.load_ohm == 0.0)
    slew_per_s = std::min(slew_per_s, config.voltage_limit_V / (1e-3 * config.load_mH));
  return slew_per_s;
}

}  // namespace

double Amplifier::target_of(const Config& config, double setpoint) {
  if (config.resolution > 0.0) setpoint = config.resolution * std::round(setpoint / config.resolution);
  return std::clamp(setpoint, config.drive_min, config.drive_max);
}

double Amplifier::discharge_s(const Config& config) {
  if (config.load_mH > 0.0 && config.load_ohm > 0.0) return 1e-3 * config.load_mH / config.load_ohm;
  return 1e-6 * config.load_uF * config.load_ohm;
}

DriveLimits Amplifier::limits(const Config& config) {
  const bool has_coil = config.load_mH > 0.0 && config.load_ohm > 0.0;
  return {.omega = 2.0 * std::numbers::pi * config.bandwidth_Hz,
          .slew_per_s = slew_into_the_load(config),
          .load_rate_per_s = has_coil ? 1e3 * config.load_ohm / config.load_mH : 0.0,
          .load_limit = has_coil ? config.voltage_limit_V / config.load_ohm : unlimited};
}

Amplifier::Step::Step(const Config& config, double dt_s)
    : dt_s_(dt_s),
      limits_(limits(config)),
      ramp_per_s_(std::min(limits_.slew_per_s, config.ramp_per_s)),
      linear_error_(limits_.slew_per_s / limits_.omega),
      decay_(std::exp(-limits_.omega * dt_s)),
      load_decay_(std::isinf(limits_.load_limit) ? 0.0 : std::exp(-limits_.load_rate_per_s * dt_s)),
      discharge_s_(discharge_s(config)) {}

Amplifier::State Amplifier::Step::operator()(const State& state) const {
  if (state.rate_per_s != 0.0) return follow(state);
  State next = state;
  const bool ramps = state.course == Course::ramp;
  if (state.course == Course::off)
    next.output = discharge_s_ > 0.0 ? state.output * std::exp(-dt_s_ / discharge_s_) : 0.0;
  else if (!std::isinf(limits_.load_limit))
    next.output = drive_the_coil(state, ramps ? ramp_per_s_ : limits_.slew_per_s);
  else if (ramps)
    next.output = drive(state, ramp_per_s_, ramp_per_s_ / limits_.omega);
  else
    next.output = drive(state, limits_.slew_per_s, linear_error_);
  return next;
}

/// Without an inductive load: lag and slew alone.
double Amplifier::Step::drive(const State& state, double slew_per_s, double linear_error) const {
  const double error = state.target - state.output;
  if (std::abs(error) <= linear_error) return state.target - error * decay_;
  const double slewing_s = (std::abs(error) - linear_error) / slew_per_s;
  if (dt_s_ <= slewing_s) return state.output + std::copysign(slew_per_s * dt_s_, error);
  return state.target - std::copysign(linear_error, error) * std::exp(-limits_.omega * (dt_s_ - slewing_s));
}

/// A moving target. The first form is that of a step within the lag alone.
Amplifier::State Amplifier::Step::follow(const State& state) const {
  State next = state;
  next.target += state.rate_per_s * dt_s_;
  const double lag = state.rate_per_s / limits_.omega;
  const double error = state.target - state.output;
  const double error_after = lag + (error - lag) * decay_;
  if (std::isinf(limits_.load_limit) && std::max(std::abs(error), std::abs(error_after)) <= linear_error_)
    next.output = next.target - error_after;
  else
    next.output = MovingTarget{state.output, state.target, state.rate_per_s}.output_after(limits_, dt_s_);
  return next;
}

double Amplifier::Step::drive_the_coil(const State& state, double slew_per_s) const {
  const double sign = state.target < state.output ? -1.0 : 1.0;
  return sign * rise(sign * state.output, slew_per_s, {limits_.omega, sign * state.target, decay_},
                     {limits_.load_rate_per_s, limits_.load_limit, load_decay_}, dt_s_);
}

}  // namespace hystcan::twin
