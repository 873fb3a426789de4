// Computes from the model and the applied drive how far the position can have moved since a given moment, as
// a lower and an upper limit. The actuator's memory and the delays are not known exactly. The measured
// position is between the smallest and the largest of four positions:
//
//   a, b           the model's positions under the two extreme memories: in a, the drive has fallen from the
//                  upper threshold; in b, it has risen from the lower threshold on the virgin curve. The
//                  actuator's memory is between these two; a ramp to the upper threshold makes them equal
//   a, b delayed   a and b, delayed by the pure delays and by a first-order lag. The time constant of the lag
//                  is the sum of the other delays and two cycles
#pragma once

#include <array>
#include <cstddef>

#include "controller/control/delays.h"
#include "model/hysteresis.h"

namespace hystcan::controller {

class Course {
 public:
  /// Four positions of the model at one moment, in um. The first two belong to the two extreme memories that
  /// the actuator can have (a and b at the top of this file). The other two are the first two after the
  /// delays of drive, stage and sensor.
  using Mark = std::array<double, 4>;

  /// Throws std::invalid_argument if the model is invalid.
  Course(const model::HysteresisParameters& parameters, const Delays& delays);

  /// Restarts at rest at this drive, as if the memory of the actuator were unknown.
  void restart(double drive);
  /// Moves the model, under both possible memories, to the drive that was commanded last.
  void follow(double drive);
  /// Computes the delayed positions of the model in mark(): the positions after the delays of drive, stage
  /// and sensor. Called once in each cycle of a driven axis, after follow().
  void elapse(double dt_s, double cycle_s);

  double position_um() const { return mark_.front(); }
  const Mark& mark() const { return mark_; }
  /// Returns the smallest and the largest possible motion of the position since the moment at which mark()
  /// returned `since`.
  model::Interval moved_um(const Mark& since) const;

 private:
  /// Positions of the model in um under the two extreme memories that the actuator can have.
  using Positions = std::array<double, 2>;
  /// The two extreme memories: after the drive has fallen from the upper threshold, and after it has risen
  /// from the lower threshold on the virgin curve.
  using Memories = std::array<model::HysteresisState, 2>;
  /// The last positions of the model, stored at equal time steps. At most 32 positions cover the pure delays.
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
  /// Length of a cycle; time constant of the first-order lag; time between two stored positions.
  double cycle_s_ = 0.0, lag_s_ = 0.0, apart_s_ = 0.0;
  std::size_t ago_ = 0;  ///< number of stored positions that the pure delays cover
  Mark mark_{};
};

}  // namespace hystcan::controller
