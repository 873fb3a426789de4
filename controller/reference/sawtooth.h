// A periodic line that rises and falls straight, with a turnaround (turnaround.h) at each end.
//
// The ideal line rises by S within T_1 and falls by S within T_2, with v_1 = S / T_1 and v_2 = S / T_2. About its upper
// corner, at tau = 0, the sawtooth is
//
//   y = top + (v_1 - v_2) / 2 tau - (v_1 + v_2) / 2 w(tau)
//
// and about the lower one the mirror image. Where w'(tau_0) = (v_2 - v_1) / (v_1 + v_2) at a lower corner, it stands:
// this is its lowest point. S is so much greater than high - low that the extremes of the sawtooth are low and high.
// The straight parts therefore lie on the ideal line, whose corners lie beyond low and high.
//
// Time begins at a lowest point.
#pragma once

#include "controller/reference/motion.h"
#include "controller/reference/turnaround.h"

namespace hystcan::controller {

class Sawtooth {
 public:
  Sawtooth() = default;
  /// `rise_share`: T_1 / (T_1 + T_2), within 0 and 1. The turnaround is not longer than T_1 or T_2.
  Sawtooth(double low_um, double high_um, double period_s, double rise_share, const Turnaround& turnaround);

  Motion at(double t_s) const;
  /// The ideal line.
  double ideal_um(double t_s) const;

  double period_s() const { return rise_s_ + fall_s_; }
  /// From the lowest to the highest point.
  double way_up_s() const { return rise_s_ - 2.0 * lowest_s_; }
  double peak_slew_um_per_s() const;
  double peak_acceleration_um_per_s2() const;

 private:
  double since_corner_s(double t_s) const;
  Motion corner(double value_um, double t_s, double sign) const;

  Turnaround turnaround_;
  double rise_s_ = 0.5;
  double fall_s_ = 0.5;
  double lowest_s_ = 0.0;  ///< of the lowest point after its corner, tau_0
  double bottom_um_ = 0.0;
  double height_um_ = 1.0;  ///< S
};

}  // namespace hystcan::controller
