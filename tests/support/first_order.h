// A first-order lag, discretised exactly.
//
//   x' = omega (u(t) - x),    omega = 2 pi f,    tau = omega dt
//
// Exact for an input that is linear in time between the two ends of a step (first-order hold); a constant
// input is the special case.  Written so that a held input equal to the value is an equilibrium to the bit,
// however short the step:
//
//   x[n+1] = x[n] + b_0 (u[n] - x[n]) + b_1 (u[n+1] - x[n])
//   b_0 = (1 - e^{-tau}) / tau - e^{-tau},    b_1 = 1 - (1 - e^{-tau}) / tau
//
// Both are accurate to rounding for every tau > 0.
#pragma once

namespace hystcan::support {

struct FirstOrder {
  struct Config {
    double bandwidth_Hz = 100.0;  ///< f > 0, where the gain is 1 / sqrt(2)
  };
  struct State {
    double value = 0.0;  ///< output units
  };
  /// The step of a fixed length, its coefficients computed once.
  class Step {
   public:
    /// Throws std::invalid_argument where the bandwidth or dt_s is not a positive number.
    Step(const Config& config, double dt_s);
    State operator()(const State& state, double input_before, double input_after) const;

   private:
    double from_before_, from_after_;  // b_0, b_1
  };
};

}  // namespace hystcan::support
