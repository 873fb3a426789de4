// Compares the output that the amplifier reports with the commanded drive. This detects an open interlock or
// a supply at its limit early, before the stage would move far when the interlock closes. The output agrees
// if both conditions hold:
//
//   |o - u| <= m + s (age + late)
//   min u - m <= o <= max u + m
//
//   o      reported output; age: time since this report
//   u      commanded drive; min u, max u: its range in the last two to three spans
//   m      margin, 5 % of the drive's range
//   s      maximum slew of the drive; late: four cycles and five lags of the amplifier
//   span   the longest of 50 ms, five cycles and five lags
//
// The first condition finds a difference during a ramp, whose slew is small. While the axis tracks, s is the
// slew limit, and the second condition is the narrower one. Each status is judged once, when it arrives. The
// verdict holds until the next status, but at most for one span: missing statuses trip the axis with another
// cause.
#pragma once

#include <array>

#include "controller/control/supervisor.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

class OutputCheck {
 public:
  /// `drive_range`: drive_max - drive_min. `lag_s`: time constant of the amplifier.
  OutputCheck(double drive_range, double lag_s) : drive_range_(drive_range), lag_s_(lag_s) {}

  void restart(double drive);
  /// Compares the reported output with `drive`, the last commanded drive, which changes by at most
  /// `slew_per_s`. Called once in each cycle of a driven axis.
  void step(double drive, double slew_per_s, const AxisInput& input);
  /// Returns for how long the amplifier's output has differed from the commanded drive without interruption;
  /// 0 if the output agrees or is not known.
  double differs_for_s() const { return differs_for_s_; }
  /// True if the amplifier's output has differed from the commanded drive for too long: for 0.5 s while the
  /// axis ramps (`ramps`), because the output may lag behind the ramp, and otherwise for 0.05 s.
  bool differs_too_long(bool ramps) const { return differs_for_s_ > (ramps ? 0.5 : 0.05); }

 private:
  bool agrees(double drive, double slew_per_s, const AxisInput& input) const;

  double drive_range_, lag_s_;
  /// Ranges of the commanded drive in the last three time intervals of one span each (see the top of this
  /// file), the present interval first.
  std::array<model::Interval, 3> spans_{};
  double span_s_ = 0.0;  ///< time for which the newest range in spans_ has been collected
  double status_age_s_ = 0.0;
  bool agrees_ = true;  ///< true if the output in the last status agreed with the drive
  double differs_for_s_ = 0.0;
};

}  // namespace hystcan::controller
