#include "controller/reference/sawtooth.h"

#include <algorithm>
#include <cmath>

namespace hystcan::controller {
namespace {

/// Where w' has this value; w' is not decreasing.
double where_slope_is(const Turnaround& turnaround, double slope) {
  if (slope == 0.0) return 0.0;  // by symmetry
  double before_s = -0.5 * turnaround.length_s();
  double after_s = -before_s;
  for (int i = 0; i < 60; ++i) {
    const double middle_s = 0.5 * (before_s + after_s);
    (turnaround.slope(middle_s) < slope ? before_s : after_s) = middle_s;
  }
  return 0.5 * (before_s + after_s);
}

}  // namespace

Sawtooth::Sawtooth(double low_um, double high_um, double period_s, double rise_share,
                   const Turnaround& turnaround)
    : turnaround_(turnaround), rise_s_(rise_share * period_s), fall_s_(period_s - rise_s_) {
  const double up = 1.0 / rise_s_;
  const double down = rise_share == 0.5 ? up : 1.0 / fall_s_;
  if (turnaround.length_s() > 0.0) lowest_s_ = where_slope_is(turnaround, (down - up) / (up + down));
  const double lost = 0.5 * (up - down) * lowest_s_ + 0.5 * (up + down) * turnaround.way_s(lowest_s_);
  height_um_ = (high_um - low_um) / (1.0 - 2.0 * lost);
  bottom_um_ = low_um - lost * height_um_;
}

/// Since the last lower corner of the ideal line.
double Sawtooth::since_corner_s(double t_s) const {
  const double s = (t_s + lowest_s_) / period_s();
  return (s - std::floor(s)) * period_s();
}

/// About a corner; `sign` is 1 for a lower one.
Motion Sawtooth::corner(double value_um, double t_s, double sign) const {
  const double up = height_um_ / rise_s_;
  const double down = height_um_ / fall_s_;
  const double half = 0.5 * sign * (up + down);
  const double tilt = 0.5 * (up - down);
  return {.value_um = value_um + tilt * t_s + half * turnaround_.way_s(t_s),
          .velocity_um_per_s = tilt + half * turnaround_.slope(t_s),
          .acceleration_um_per_s2 = half * turnaround_.curvature_per_s(t_s)};
}

Motion Sawtooth::at(double t_s) const {
  const double tau_s = since_corner_s(t_s);
  if (tau_s < 0.5 * rise_s_) return corner(bottom_um_, tau_s, 1.0);
  if (tau_s < rise_s_ + 0.5 * fall_s_) return corner(bottom_um_ + height_um_, tau_s - rise_s_, -1.0);
  return corner(bottom_um_, tau_s - period_s(), 1.0);
}

double Sawtooth::ideal_um(double t_s) const {
  const double tau_s = since_corner_s(t_s);
  const double share = tau_s < rise_s_ ? tau_s / rise_s_ : (period_s() - tau_s) / fall_s_;
  return bottom_um_ + height_um_ * share;
}

double Sawtooth::peak_slew_um_per_s() const { return std::abs(height_um_) / std::min(rise_s_, fall_s_); }

double Sawtooth::peak_acceleration_um_per_s2() const {
  return 0.5 * std::abs(height_um_) * (1.0 / rise_s_ + 1.0 / fall_s_) * turnaround_.peak_curvature_per_s();
}

}  // namespace hystcan::controller
