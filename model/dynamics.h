// The dynamics of a stage: the position x follows the output h of the hysteresis through a second-order mode
// and a pure delay.
//
//   x'' + 2 zeta omega x' + omega^2 x = omega^2 h(t - d),    h(t) = h_n for n T <= t < (n + 1) T
//
//   h_n           output of the hysteresis in row n
//   T             time between two rows
//   omega, zeta   natural angular frequency and damping ratio of the mode
//   d             delay
//
// A delay of the input has the same effect as a delay of the output, because the hysteresis does not depend
// on the rate. At the beginning the stage is at rest.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "model/held_mode.h"
#include "model/second_order.h"

namespace hystcan::model {

struct Dynamics {
  SecondOrder::Config mode;
  double delay_s = 0.0;  ///< delay of the stage; 0 or more

  bool operator==(const Dynamics&) const = default;
};

/// Computes the position of a stage row by row from the output of its hysteresis. The time between two rows
/// is constant.
class DynamicOutput {
 public:
  /// `cycle_s`: time between two rows. `first`: output of the hysteresis in the first row, at which the stage
  /// rests. Throws std::invalid_argument if a parameter is not finite or out of range, if cycle_s <= 0, or if
  /// the delay exceeds a million cycles.
  DynamicOutput(const Dynamics& dynamics, double cycle_s, double first);

  /// Returns the position in the next row. `quasi_static` is the output of the hysteresis in the same row; it
  /// has an effect only on later positions.
  double advance(double quasi_static);

 private:
  HeldMode mode_;
  Eigen::Vector2d state_;
  // Ring buffer of the last m + 2 outputs of the hysteresis, for a delay of m whole cycles.
  std::vector<double> past_;
  std::size_t oldest_ = 0;
};

}  // namespace hystcan::model
