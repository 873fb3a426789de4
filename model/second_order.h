// A second-order mode, discretised exactly.
//
//   x'' + 2 zeta omega x' + omega^2 x = omega^2 u(t),    omega = 2 pi f
//
// The step is exact for an input that is linear in time between the two ends of the step (first-order hold);
// a constant input is a special case.  The damping ratio zeta is >= 0.  The b are the sensitivities of the
// exact step.  The form guarantees a gain of 1 at rest: an input that is held equal to the position is an
// exact equilibrium (to the bit), for any length of the step:
//
//   x[n+1] = x[n] + b_xv x'[n] + b_x0 (u[n] - x[n]) + b_x1 (u[n+1] - x[n])
//   x'[n+1] =       b_vv x'[n] + b_v0 (u[n] - x[n]) + b_v1 (u[n+1] - x[n])
#pragma once

namespace hystcan::model {

/// A second-order mode with steps of fixed length. The coefficients are computed once.
class SecondOrder {
 public:
  struct Config {
    double natural_frequency_Hz = 100.0;  ///< f > 0
    double damping_ratio = 0.1;           ///< zeta >= 0

    bool operator==(const Config&) const = default;
  };
  struct State {
    double position = 0.0;  ///< output units
    double velocity = 0.0;  ///< output units per second
  };

  /// Throws std::invalid_argument if a parameter is not finite or out of range, or if dt_s <= 0.
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
