// The dynamics of a stage: a second-order mode and a pure delay behind the hysteresis.
//
//   h_n  = H[v_n]                                      quasi-static output at row n, of any hysteresis model
//   x'' + 2 zeta omega x' + omega^2 x = omega^2 h(t - d),    h(t) = h_n for n T <= t < (n + 1) T
//
// A delay at the input and a delay at the output have the same effect, because the hysteresis does not depend
// on the rate. The stage starts at rest.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "model/held_mode.h"
#include "model/second_order.h"

namespace hystcan::model {

struct Dynamics {
  SecondOrder::Config mode;
  double delay_s = 0.0;  ///< d >= 0

  bool operator==(const Dynamics&) const = default;
};

/// The position of a stage, computed row by row at a constant rate.
class DynamicOutput {
 public:
  /// `first`: quasi-static output of the first row. Throws std::invalid_argument if a parameter is not finite
  /// or out of range, if cycle_s <= 0, or if the delay exceeds a million cycles.
  DynamicOutput(const Dynamics& dynamics, double cycle_s, double first);

  /// Returns the position x(n T) of row n. `quasi_static`: output h_n of the hysteresis in this row.
  double advance(double quasi_static);

 private:
  HeldMode mode_;
  Eigen::Vector2d state_;
  std::vector<double> past_;  // ring of the last m + 2 quasi-static outputs; m: whole cycles of delay
  std::size_t oldest_ = 0;
};

}  // namespace hystcan::model
