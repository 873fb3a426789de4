#include "twin/amplifier.h"

#include <cmath>
#include <numbers>

namespace hystcan::twin {

Amplifier::Step::Step(const Config& config, double dt_s)
    : dt_s_(dt_s),
      omega_(2.0 * std::numbers::pi * config.bandwidth_Hz),
      slew_per_s_(config.slew_per_s),
      linear_error_(config.slew_per_s / omega_),
      decay_(std::exp(-omega_ * dt_s)) {}

Amplifier::State Amplifier::Step::operator()(const State& state) const {
  const double error = state.target - state.output;
  if (std::abs(error) <= linear_error_) return {state.target - error * decay_, state.target};
  const double slewing_s = (std::abs(error) - linear_error_) / slew_per_s_;
  if (dt_s_ <= slewing_s) return {state.output + std::copysign(slew_per_s_ * dt_s_, error), state.target};
  return {state.target - std::copysign(linear_error_, error) * std::exp(-omega_ * (dt_s_ - slewing_s)),
          state.target};
}

}  // namespace hystcan::twin
