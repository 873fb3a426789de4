// What the drive makes of the position, by the model: how far it can have moved since a moment.
//
//   a, b    the model's positions under two memories: the drive has come down from the upper threshold, or up from the lower
//           one on the virgin curve. The actuator's memory lies between them, and a wipe makes them equal
//   slow    each through a first-order lag, of the delays and two cycles: what a sample shows lies between the two
#pragma once

#include <array>

#include "controller/control/delays.h"
#include "model/hysteresis.h"

namespace hystcan::controller {

class Course {
 public:
  /// Positions at one moment.
  struct Mark {
    struct Position {
      double now_um = 0.0, slow_um = 0.0;
    };
    std::array<Position, 2> positions{};
  };

  /// Throws std::invalid_argument where the model is invalid.
  Course(const model::HysteresisParameters& parameters, const Delays& delays);

  /// At rest at this drive, with an unknown memory.
  void restart(double drive);
  /// Called once in each cycle of a driven axis, with the drive that was commanded last.
  void step(double drive, double dt_s, double cycle_s);

  const Mark& mark() const { return mark_; }
  model::Interval moved_um(const Mark& since) const;

 private:
  model::Hysteresis model_;
  Delays delays_;
  model::HysteresisState at_upper_, at_lower_;  ///< thresholds
  std::array<model::HysteresisState, 2> memories_;
  Mark mark_;
};

}  // namespace hystcan::controller
