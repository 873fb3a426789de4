#include "twin/amplifier.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace hystcan::twin {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// A curve g(t) = a + b t + c e^{-kt}.
struct Curve {
  double a, b, c, k;
  double at(double t_s) const { return a + b * t_s + c * std::exp(-k * t_s); }
};

/// Returns the curve share * g(t) + shift.
Curve scaled(const Curve& g, double share, double shift) {
  return {share * g.a + shift, share * g.b, share * g.c, g.k};
}
/// Adds two curves that decay at the same rate k.
Curve sum(const Curve& one, const Curve& other) {
  return {one.a + other.a, one.b + other.b, one.c + other.c, one.k};
}

/// Returns the time at which g, which falls from `from_s` to `to_s`, passes zero between these times.
double zero_between(const Curve& g, double from_s, double to_s) {
  if (g.at(from_s) <= 0.0) return from_s;
  while (true) {
    const double middle_s = 0.5 * (from_s + to_s);
    if (middle_s <= from_s || middle_s >= to_s) return to_s;
    (g.at(middle_s) > 0.0 ? from_s : to_s) = middle_s;
  }
}

/// Returns the first time at which the curve g falls below zero; `never` if the curve does not fall below
/// zero before `end_s`. If the curve begins at zero and rises, its beginning does not count.
double falls_below_zero(const Curve& g, double end_s) {
  const double ratio = g.k * g.c / g.b;  // value of e^{kt} at the extremum of the curve g(t) (struct Curve)
  const double extremum_s = ratio > 1.0 ? std::min(std::log(ratio) / g.k, end_s) : end_s;
  for (const auto& [from_s, to_s] : {std::pair(0.0, extremum_s), std::pair(extremum_s, end_s)})
    if (const double last = g.at(to_s); from_s < to_s && last < 0.0 && last < g.at(from_s))
      return zero_between(g, from_s, to_s);
  return never;
}

enum class Phase : std::uint8_t { lag, slews_up, slews_down, load_up, load_down };

/// Computes the output v of the amplifier over time, phase by phase (formulas: twin/amplifier.h).
class OutputCourse {
 public:
  OutputCourse(const Amplifier::State& start, const DriveLimits& limits)
      : now_(start), limits_(limits), has_load_(std::isfinite(limits.load_limit)), phase_(first_phase()) {}

  double output_after(double left_s) {
    for (int phases = 0; phases < most_phases; ++phases) {
      const auto [end_s, next] = end_of_phase(left_s);
      if (end_s >= left_s) break;
      pass(end_s, next);
      left_s -= end_s;
    }
    return output().at(left_s);
  }

  double turns_after_s(double time_s) {
    double passed_s = 0.0;
    for (int phases = 0; phases < most_phases; ++phases) {
      const double left_s = time_s - passed_s;
      const auto [end_s, next] = end_of_phase(left_s);
      if (phase_ == Phase::lag)
        if (const double turn_s = falls_below_zero(scaled(error(), now_.rate_per_s > 0.0 ? -1.0 : 1.0, 0.0),
                                                   std::min(end_s, left_s));
            turn_s < never)
          return passed_s + turn_s;
      if (end_s >= left_s) break;
      pass(end_s, next);
      passed_s += end_s;
    }
    return never;
  }

 private:
  /// Maximum number of phases (lag, slew limit, voltage limit) that are computed for one time step. A real
  /// step has fewer phases. The limit is needed because rounding could make two phases alternate forever.
  static constexpr int most_phases = 32;

  struct End {
    double time_s = never;
    Phase next = Phase::lag;
  };

  double error_now() const { return now_.target - now_.output; }

  Phase first_phase() const {
    const double demanded_rate = limits_.omega * error_now();
    const double rising = has_load_ ? limits_.load_rate_per_s * (limits_.load_limit - now_.output) : never;
    const double falling = has_load_ ? limits_.load_rate_per_s * (limits_.load_limit + now_.output) : never;
    if (demanded_rate > std::min(limits_.slew_per_s, rising))
      return rising < limits_.slew_per_s ? Phase::load_up : Phase::slews_up;
    if (-demanded_rate > std::min(limits_.slew_per_s, falling))
      return falling < limits_.slew_per_s ? Phase::load_down : Phase::slews_down;
    return Phase::lag;
  }

  Curve output() const {
    switch (phase_) {
      case Phase::slews_up:
        return {now_.output, limits_.slew_per_s, 0.0, 0.0};
      case Phase::slews_down:
        return {now_.output, -limits_.slew_per_s, 0.0, 0.0};
      case Phase::load_up:
        return {limits_.load_limit, 0.0, now_.output - limits_.load_limit, limits_.load_rate_per_s};
      case Phase::load_down:
        return {-limits_.load_limit, 0.0, now_.output + limits_.load_limit, limits_.load_rate_per_s};
      case Phase::lag:
        break;
    }
    const double lag = now_.rate_per_s / limits_.omega;
    return {now_.target - lag, now_.rate_per_s, lag - error_now(), limits_.omega};
  }

  /// Returns the error, target minus output, as a curve over time.
  Curve error() const {
    Curve e = scaled(output(), -1.0, now_.target);
    e.b += now_.rate_per_s;
    return e;
  }

  End end_of_phase(double left_s) const {
    const Curve demanded_rate = scaled(error(), limits_.omega, 0.0);
    const Curve opposite = scaled(demanded_rate, -1.0, 0.0);
    const double slew = limits_.slew_per_s, rho = limits_.load_rate_per_s, limit = limits_.load_limit;
    const auto rising = [&] { return scaled(output(), -rho, rho * limit); };
    const auto falling = [&] { return scaled(output(), rho, rho * limit); };
    const auto minus = [](const Curve& g) { return scaled(g, -1.0, 0.0); };
    End end;
    const auto ends_where = [&](const Curve& falls, Phase next) {
      if (const double time_s = falls_below_zero(falls, left_s); time_s < end.time_s) end = {time_s, next};
    };
    switch (phase_) {
      case Phase::lag:
        ends_where(scaled(opposite, 1.0, slew), Phase::slews_up);
        ends_where(scaled(demanded_rate, 1.0, slew), Phase::slews_down);
        if (has_load_) ends_where(sum(rising(), opposite), Phase::load_up);
        if (has_load_) ends_where(sum(falling(), demanded_rate), Phase::load_down);
        break;
      case Phase::slews_up:
        ends_where(scaled(demanded_rate, 1.0, -slew), Phase::lag);
        if (has_load_) ends_where(scaled(rising(), 1.0, -slew), Phase::load_up);
        break;
      case Phase::slews_down:
        ends_where(scaled(opposite, 1.0, -slew), Phase::lag);
        if (has_load_) ends_where(scaled(falling(), 1.0, -slew), Phase::load_down);
        break;
      case Phase::load_up:
        ends_where(sum(demanded_rate, minus(rising())), Phase::lag);
        break;
      case Phase::load_down:
        ends_where(sum(opposite, minus(falling())), Phase::lag);
        break;
    }
    return end;
  }

  void pass(double time_s, Phase next) {
    now_.output = output().at(time_s);
    now_.target += now_.rate_per_s * time_s;
    phase_ = next;
  }

  Amplifier::State now_;
  DriveLimits limits_;
  bool has_load_;
  Phase phase_;
};

double slew_into_the_load(const Amplifier::Config& config) {
  double slew_per_s = config.slew_per_s;
  if (config.load_uF > 0.0)
    slew_per_s = std::min(slew_per_s, config.current_limit_A / (1e-6 * config.load_uF));
  if (config.load_mH > 0.0 && config.load_ohm == 0.0)
    slew_per_s = std::min(slew_per_s, config.voltage_limit_V / (1e-3 * config.load_mH));
  return slew_per_s;
}

}  // namespace

double Amplifier::State::output_after(const DriveLimits& limits, double time_s) const {
  return OutputCourse(*this, limits).output_after(time_s);
}

double Amplifier::State::turns_after_s(const DriveLimits& limits, double time_s) const {
  if ((target - output) * rate_per_s >= 0.0) return never;
  return OutputCourse(*this, limits).turns_after_s(time_s);
}

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

Amplifier::Amplifier(const Config& config, double dt_s)
    : dt_s_(dt_s),
      limits_(limits(config)),
      ramp_limits_(limits_),
      decay_(std::exp(-limits_.omega * dt_s)),
      discharge_s_(discharge_s(config)) {
  ramp_limits_.slew_per_s = std::min(limits_.slew_per_s, config.ramp_per_s);
}

Amplifier::State Amplifier::operator()(const State& state) const {
  State next = state;
  if (state.course == Course::off) {
    next.output = discharge_s_ > 0.0 ? state.output * std::exp(-dt_s_ / discharge_s_) : 0.0;
    return next;
  }
  const DriveLimits& limits = state.course == Course::ramp ? ramp_limits_ : limits_;
  next.target += state.rate_per_s * dt_s_;
  const double lag = state.rate_per_s / limits.omega;
  const double error_after = lag + (state.target - state.output - lag) * decay_;
  next.output = next.target - error_after;
  const bool may_leave_the_lag = state.rate_per_s != 0.0 && !std::isinf(limits.load_limit);
  if (may_leave_the_lag || !is_within(limits, state) || !is_within(limits, next))
    next.output = state.output_after(limits, dt_s_);
  return next;
}

/// Returns true if no limit acts in this state: the rate that a lag without limits would have is within the
/// slew limit and the voltage limit. With a constant target, or without a voltage limit, a result that is
/// true at both ends of a step is true during the whole step. The reason: rate and limits are linear in the
/// error (target minus output), and the error is monotone. With a moving target and a voltage limit, a limit
/// can act in the middle of the step.
bool Amplifier::is_within(const DriveLimits& limits, const State& state) {
  const double demanded_rate = limits.omega * (state.target - state.output);
  if (std::abs(demanded_rate) > limits.slew_per_s) return false;
  return std::isinf(limits.load_limit) ||
         (demanded_rate <= limits.load_rate_per_s * (limits.load_limit - state.output) &&
          -demanded_rate <= limits.load_rate_per_s * (limits.load_limit + state.output));
}

}  // namespace hystcan::twin
