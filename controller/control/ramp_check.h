// Compares the motion of the position during the ramps of the start-up with the motion of the model (Course).
// Before the axis tracks, this detects a sensor that is reversed or scaled wrongly, or an amplifier whose
// output stops before the end of its range. The position agrees with the model if:
//
//   s (y - y_0) >= -d / 4 - e              since the start or the last turn of the ramp
//   s (y - y_1) >= (1 - p) d - e           since the beginning of a window
//   s (y - y_1) <= D / (1 - p) + e         since the beginning of a window
//
//   s          direction in which the model's position moves, 1 or -1
//   y          mean of the samples over about two cycles, minus the coupling from the other axes
//   y_0, y_1   y at the start or turn of the ramp, y at the beginning of the window
//   d, D       smallest and largest motion of the model. If d < 0, the lower limit is d / (1 - p) - e.
//              D >= 0, because the windows restart when the model turns
//   p          `slope_shortfall`
//   e          allowed error: the sum of 0.3 % of the stroke, the ringing v / w at corners of the ramp, and
//              the range of y at rest before the ramp
//   v, w       speed of the model in the ramp, angular frequency of the mode
//
// A window covers 14 % of the drive's range and at least six cycles. The first window begins after 8 % of the
// range, when delays do not matter any more. The range of y at rest decays in 200 cycles, or in the time in
// which the ringing of the mode decays (`decay_s`) if that is longer. This range is at least 2 v' / w, where
// v' is the highest speed of y at rest: a slow mode may not have shown its full range yet.
#pragma once

#include <optional>

#include "controller/control/course.h"
#include "controller/control/supervisor.h"

namespace hystcan::controller {

class RampCheck {
 public:
  struct Config {
    double drive_range = 0.0;  ///< range of the drive, drive_max - drive_min
    double stroke_um = 0.0;
    double ramp_um_per_s = 0.0;
    double mode_rad_per_s = 1.0;
    double decay_s = 0.0;          ///< time in which the ringing of the stage's mode decays
    double slope_shortfall = 0.0;  ///< share by which a stage may be less steep than its model
  };

  explicit RampCheck(const Config& config) : config_(config) {}

  void restart() { *this = RampCheck(config_); }
  /// Called once in each cycle of the start-up until its ramp begins. Measures the range in which the
  /// position varies at rest.
  void rest(const Course& course, double drive, const AxisInput& input);
  /// Called once in each cycle of the start-up from the beginning of its ramp on, with the last commanded
  /// drive. Returns false if the position does not agree with the model for the third cycle in a row.
  bool step(const Course& course, double drive, const AxisInput& input);

 private:
  /// A moment with which the present motion is compared: the last turn of the ramp, or the beginning of a
  /// window.
  struct Anchor {
    Course::Mark model{};
    double seen_um = 0.0;  ///< measured position at the turn of the ramp or at the beginning of the window
    double drive = 0.0;
    unsigned cycles = 0;  ///< number of cycles since the turn of the ramp or the beginning of the window
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
  std::optional<double> seen_um_;      ///< measured position, averaged over about two cycles
  model::Interval rest_um_{0.0, 0.0};  ///< range of the measured position at rest
  double model_um_ = 0.0;              ///< model's position in the last cycle
  double direction_ = 0.0;             ///< direction of the model's motion, 1 or -1; 0: at rest
  Anchor turn_;
  std::optional<Anchor> window_;
  unsigned contradictions_ = 0;  ///< consecutive cycles in which position and model do not agree
};

}  // namespace hystcan::controller
