// Compares the motion of the position during the ramps of the start-up with the model's motion (Course). This
// detects a sensor that is reversed or scaled wrongly, or an amplifier that ends below its range, before the
// axis tracks.
//
//   s (y - y_0) >= -d / 4 - e               since the start or the turn of the ramp
//   s (y - y_1) >= (1 - p) d - e            } in windows of 14 % of the drive's range, at least six cycles.
//   s (y - y_1) <= D / (1 - p) + e          } The first begins after 8 %, when delays do not matter any more
//
//   s       direction in which the model's position moves
//   d, D    the smallest and the largest possible motion of the model; for d < 0, the bound is d / (1 - p).
//           D >= 0, because the windows restart when the model turns
//   y       mean of the samples over about two cycles, minus the coupling from the other axes
//   p       `slope_shortfall`
//   e       sum of 0.3 % of the stroke, the ringing at the corners of the ramp, v / w, and the range of y at
//           rest before the ramp. This range decays in 200 cycles, or in decay_s. It is at least 2 v' / w, in
//           case a slow mode has not shown its full range; v, v': speed of the model in the ramp, highest
//           speed of y at rest, w: angular frequency of the mode
#pragma once

#include <optional>

#include "controller/control/course.h"
#include "controller/control/supervisor.h"

namespace hystcan::controller {

class RampCheck {
 public:
  struct Config {
    double drive_range = 0.0;  ///< drive_max - drive_min
    double stroke_um = 0.0;
    double ramp_um_per_s = 0.0;
    double mode_rad_per_s = 1.0;
    double decay_s = 0.0;          ///< time in which the ringing decays
    double slope_shortfall = 0.0;  ///< share by which a stage may be less steep than its model
  };

  explicit RampCheck(const Config& config) : config_(config) {}

  void restart() { *this = RampCheck(config_); }
  /// Called once in each cycle before the ramp, beginning when the axis waits.
  void rest(const Course& course, double drive, const AxisInput& input);
  /// Called once in each later cycle of the start-up, with the last commanded drive. Returns false if the
  /// position contradicts the drive for the third cycle in a row.
  bool step(const Course& course, double drive, const AxisInput& input);

 private:
  struct Anchor {
    Course::Mark model{};
    double seen_um = 0.0;  ///< measured position (y_0 or y_1) at the anchor
    double drive = 0.0;
    unsigned cycles = 0;  ///< cycles since the anchor was set
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
  std::optional<double> seen_um_;      ///< measured position y, averaged
  model::Interval rest_um_{0.0, 0.0};  ///< range of y at rest
  double model_um_ = 0.0;              ///< model's position in the last cycle
  double direction_ = 0.0;             ///< direction s of the model's motion; 0: at rest
  Anchor turn_;
  std::optional<Anchor> window_;
  unsigned contradictions_ = 0;  ///< cycles in a row that contradict the drive
};

}  // namespace hystcan::controller
