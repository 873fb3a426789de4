// Checks of amplifier and stage against the drive: what the output, and by the model the position, must have
// done.
#pragma once

#include <array>
#include <optional>

#include "controller/control/delays.h"
#include "controller/control/supervisor.h"
#include "model/hysteresis.h"

namespace hystcan::controller {

// Compares what the amplifier says that it puts out with what it was commanded. An interlock that is open, or
// a supply at its limit, is found before the stage has far to go when it closes.
//
//   |o - u| <= m + s (age + late)       s: slew of the drive, late: four cycles and five lags
//   min u - m <= o <= max u + m         u: drives of the last two to three spans, m: 5 % of the drive's range
//
// The first one finds it in a ramp, whose slew is small. While the axis tracks, s is the limit of the slew,
// and the second one is the narrower one. A span is 50 ms, and at least five cycles and five lags. Each
// status is judged once, when it comes, and its verdict stands until the next one, for a span at most: that
// statuses are missing has a cause of its own.

class OutputCheck {
 public:
  /// `drive_range`: drive_max - drive_min; `lag_s`: of the amplifier.
  OutputCheck(double drive_range, double lag_s) : drive_range_(drive_range), lag_s_(lag_s) {}

  void restart(double drive);
  /// Called once in each cycle of a driven axis, with the drive that was commanded last, which moves by at
  /// most `slew_per_s`.
  void step(double drive, double slew_per_s, const AxisInput& input);
  /// For how long the output has differed without a break; 0: it agrees, or it is not known.
  double differs_for_s() const { return differs_for_s_; }

 private:
  bool agrees(double drive, double slew_per_s, const AxisInput& input) const;

  double drive_range_, lag_s_;
  std::array<model::Interval, 3> spans_{};  ///< drives in them; the present one first
  double span_s_ = 0.0;                     ///< so far of the present one
  double status_age_s_ = 0.0;
  bool agrees_ = true;  ///< the last status
  double differs_for_s_ = 0.0;
};

// What the drive makes of the position, by the model: how far it can have moved since a moment.
//
//   a, b    the model's positions under two memories: the drive has come down from the upper threshold, or up
//           from the lower one on the virgin curve. The actuator's memory lies between them, and a wipe makes
//           them equal
//   slow    each after the pure delays, through a first-order lag of the others and two cycles: what a sample
//           shows lies between

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

// Compares the position with what the ramps of the start-up must do to it by the model (Course): a sensor
// that is reversed or scaled wrongly, or an amplifier that ends below its range, is found before the axis
// tracks.
//
//   s (y - y_0) >= -d / 4 - e               since the ramp began or turned
//   s (y - y_1) >= (1 - p) d - e            } in windows of 14 % of the drive's range, the first one after
//   s (y - y_1) <= D / (1 - p) + e          } 8 %, when the delays do not matter any more; six cycles each
//
//   s       direction in which the model's position moves
//   d, D    the least and the most that it has moved; where d < 0, the bound is d / (1 - p). D >= 0, because
//           the windows begin again where the model turns
//   y       mean of the samples over about two cycles, less what the other axes have added
//   p       `doubt`
//   e       0.3 % of the stroke, the ringing at the corners of the ramp, v / w, and the range of y at rest
//           before, which is forgotten in 200 cycles, or in decay_s. That range is 2 v' / w at least, where a
//           slow mode has not shown it all; v, v': speed of the model in the ramp, highest speed of y at
//           rest, w: angular frequency of the mode

class RampCheck {
 public:
  struct Config {
    double drive_range = 0.0;  ///< drive_max - drive_min
    double stroke_um = 0.0;
    double ramp_um_per_s = 0.0;
    double mode_rad_per_s = 1.0;
    double decay_s = 0.0;  ///< in which ringing is forgotten
    double doubt = 0.0;    ///< share by which a stage may be less steep than its model
  };

  explicit RampCheck(const Config& config) : config_(config) {}

  void restart() { *this = RampCheck(config_); }
  /// Called once in each cycle before, from when the axis waits on.
  void rest(const Course& course, double drive, const AxisInput& input);
  /// Called once in each later cycle of the start-up, with the drive that was commanded last. False: the
  /// position contradicts the drive, for the third cycle in a row.
  bool step(const Course& course, double drive, const AxisInput& input);

 private:
  struct Anchor {
    Course::Mark model{};
    double seen_um = 0.0;  ///< y_0 or y_1
    double drive = 0.0;
    unsigned cycles = 0;  ///< since then
  };

  void see(const AxisInput& input);
  void widen_rest(const AxisInput& input, const std::optional<double>& last_um);
  Anchor here(const Course& course, double drive) const;
  bool is_beyond(const Anchor& anchor, double share, double drive) const;
  bool agrees_in_direction(const Course& course) const;
  bool agrees_in_size(const Course& course) const;
  model::Interval moved_um(const Course& course, const Anchor& anchor) const;
  double error_um() const;

  Config config_;
  std::optional<double> seen_um_;      ///< y
  model::Interval rest_um_{0.0, 0.0};  ///< of y
  double model_um_ = 0.0;              ///< in the last cycle
  double direction_ = 0.0;             ///< s; 0: at rest
  Anchor turn_;
  std::optional<Anchor> window_;
  unsigned contradictions_ = 0;  ///< in a row
};

}  // namespace hystcan::controller
