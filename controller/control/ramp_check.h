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
