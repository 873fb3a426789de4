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
#pragma once

#include <array>

#include "controller/control/supervisor.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

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
  /// While it ramps, the axis waits for an output that is behind.
  bool differs_too_long(bool ramps) const { return differs_for_s_ > (ramps ? 0.5 : 0.05); }

 private:
  bool agrees(double drive, double slew_per_s, const AxisInput& input) const;

  double drive_range_, lag_s_;
  std::array<model::Interval, 3> spans_{};  ///< drives in them; the present one first
  double span_s_ = 0.0;                     ///< so far of the present one
  double status_age_s_ = 0.0;
  bool agrees_ = true;  ///< the last status
  double differs_for_s_ = 0.0;
};

}  // namespace hystcan::controller
