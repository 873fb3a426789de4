// What the drive makes of the position, by the model: how far it can have moved since a moment.
//
//   a, b    the model's positions under two memories: the drive has come down from the upper threshold, or up
//           from the lower one on the virgin curve. The actuator's memory lies between them, and a wipe makes
//           them equal
//   slow    each after the pure delays, through a first-order lag of the others and two cycles: what a sample
//           shows lies between
#pragma once

#include <array>
#include <cstddef>

#include "controller/control/delays.h"
#include "model/hysteresis.h"

namespace hystcan::controller {

class Course {
 public:
  /// Positions at one moment, um: a, b, and both slow.
  using Mark = std::array<double, 4>;

  /// Throws std::invalid_argument where the model is invalid.
  Course(const model::HysteresisParameters& parameters, const Delays& delays);

  /// At rest at this drive, with an unknown memory.
  void restart(double drive);
  /// Called once in each cycle of a driven axis, with the drive that was commanded last.
  void step(double drive, double dt_s, double cycle_s);

  double position_um() const { return mark_.front(); }
  const Mark& mark() const { return mark_; }
  model::Interval moved_um(const Mark& since) const;

 private:
  using Positions = std::array<double, 2>;                 ///< a, b
  using Memories = std::array<model::HysteresisState, 2>;  ///< of a, b
  /// Those of the pure delays, at most 32, equally far apart in time.
  struct UnderWay {
    std::array<Positions, 32> past{};
    std::size_t newest = 0;
    double since_newest_s = 0.0;
  };
  void plan(double cycle_s);
  Positions delayed(const Positions& now, double dt_s);

  model::Hysteresis model_;
  Delays delays_;
  Memories at_thresholds_, memories_;
  UnderWay under_way_;
  double cycle_s_ = 0.0, lag_s_ = 0.0, apart_s_ = 0.0;  ///< cycle; first-order lag; of positions under way
  std::size_t ago_ = 0;                                 ///< positions in the pure delays
  Mark mark_{};
};

}  // namespace hystcan::controller
