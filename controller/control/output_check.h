// Compares the output that the amplifier reports with the commanded drive. This detects an open interlock or
// a supply at its limit early, before the stage would move far when the interlock closes.
//
//   |o - u| <= m + s (age + late)       s: slew of the drive, late: four cycles and five lags
//   min u - m <= o <= max u + m         u: drives in the last two to three spans, m: 5 % of the drive's range
//
// The first condition finds the difference during a ramp, whose slew is small. While the axis tracks, s is
// the slew limit, and the second condition is the narrower one. A span is the longest of 50 ms, five cycles
// and five lags. Each status is judged once, when it arrives. The verdict holds until the next status, but at
// most for one span: missing statuses have a cause of their own.
#pragma once

#include <array>

#include "controller/control/supervisor.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

class OutputCheck {
 public:
  /// `drive_range`: drive_max - drive_min; `lag_s`: lag of the amplifier.
  OutputCheck(double drive_range, double lag_s) : drive_range_(drive_range), lag_s_(lag_s) {}

  void restart(double drive);
  /// Called once in each cycle of a driven axis, with the last commanded drive, which moves by at most
  /// `slew_per_s`.
  void step(double drive, double slew_per_s, const AxisInput& input);
  /// Returns for how long the output has differed without interruption; 0 if it agrees or is not known.
  double differs_for_s() const { return differs_for_s_; }
  /// True if the difference lasts longer than allowed. While the axis ramps (`ramps`), it waits longer for an
  /// output that lags behind.
  bool differs_too_long(bool ramps) const { return differs_for_s_ > (ramps ? 0.5 : 0.05); }

 private:
  bool agrees(double drive, double slew_per_s, const AxisInput& input) const;

  double drive_range_, lag_s_;
  std::array<model::Interval, 3> spans_{};  ///< ranges of the drive in each span, the present span first
  double span_s_ = 0.0;                     ///< elapsed time of the present span
  double status_age_s_ = 0.0;
  bool agrees_ = true;  ///< verdict on the last status
  double differs_for_s_ = 0.0;
};

}  // namespace hystcan::controller
