// A first-order lag, discretised exactly.
//
//   x' = omega (u(t) - x),    omega = 2 pi f,    tau = omega dt
//
// The step is exact for an input that is linear in time between the two ends of the step (first-order hold);
// a constant input is a special case.  In this form an input that is held equal to the value is an exact
// equilibrium (to the bit), for any length of the step:
//
//   x[n+1] = x[n] + b_0 (u[n] - x[n]) + b_1 (u[n+1] - x[n])
//   b_0 = (1 - e^{-tau}) / tau - e^{-tau},    b_1 = 1 - (1 - e^{-tau}) / tau
//
// b_0 and b_1 are accurate to rounding for every tau > 0.
#pragma once

namespace hystcan::support {

struct FirstOrder {
  struct Config {
    double bandwidth_Hz = 100.0;  ///< f > 0: the gain is 1 / sqrt(2) there
  };
  struct State {
    double value = 0.0;  ///< output units
  };
  /// A step of fixed length; its coefficients are computed once.
  class Step {
   public:
    /// Throws std::invalid_argument if the bandwidth or dt_s is not a positive number.
    Step(const Config& config, double dt_s);
    State operator()(const State& state, double input_before, double input_after) const;

   private:
    double from_before_, from_after_;  // b_0, b_1
  };
};

}  // namespace hystcan::support
