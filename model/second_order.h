// A second-order mode (mass, spring, damper) whose steps in time are exact.
//
//   x'' + 2 zeta omega x' + omega^2 x = omega^2 u(t),    omega = 2 pi f
//
//   x       position
//   u       input, in the unit of x
//   f       natural frequency
//   zeta    damping ratio, 0 or more
//
// A step is exact if the input is linear in time during the step (first-order hold); a constant input is a
// special case. The six coefficients b describe the effect of the start values on the position and the
// velocity after the step:
//
//   x[n+1]  = x[n] + b_xv x'[n] + b_x0 (u[n] - x[n]) + b_x1 (u[n+1] - x[n])
//   x'[n+1] =        b_vv x'[n] + b_v0 (u[n] - x[n]) + b_v1 (u[n+1] - x[n])
//
// In this form, the gain at rest is exactly 1: if a constant input equals the position, the position does not
// change by a single bit, for any length of the step.
#pragma once

namespace hystcan::model {

/// Advances a second-order mode in steps of fixed length. The constructor computes all coefficients.
class SecondOrder {
 public:
  struct Config {
    double natural_frequency_Hz = 100.0;  ///< greater than 0
    double damping_ratio = 0.1;           ///< 0 or more

    bool operator==(const Config&) const = default;
  };
  struct State {
    double position = 0.0;  ///< position x, output units
    double velocity = 0.0;  ///< velocity dx/dt, output units per second
  };

  /// Throws std::invalid_argument if a parameter is not finite or out of range, if dt_s <= 0, or if a step
  /// would be longer than a million time constants.
  SecondOrder(const Config& config, double dt_s);
  State operator()(const State& state, double input_before, double input_after) const {
    const double before = input_before - state.position;
    const double after = input_after - state.position;
    return {state.position + position_from_velocity_ * state.velocity + position_from_before_ * before +
                position_from_after_ * after,
            velocity_from_velocity_ * state.velocity + velocity_from_before_ * before +
                velocity_from_after_ * after};
  }

 private:
  double position_from_velocity_, position_from_before_, position_from_after_;
  double velocity_from_velocity_, velocity_from_before_, velocity_from_after_;
};

}  // namespace hystcan::model
