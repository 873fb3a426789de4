// A smooth way from a motion to rest: the quintic x(s), s = t / T, of least jerk between (x_0, v_0, a_0) and
// (x_1, 0, 0), with D = x_1 - x_0, c_1 = v_0 T, c_2 = a_0 T^2 / 2:
//
//   x(s) = x_0 + c_1 s + c_2 s^2 + (10 D - 6 c_1 - 3 c_2) s^3 + (8 c_1 + 3 c_2 - 15 D) s^4
//          + (6 D - 3 c_1 - c_2) s^5
//
// From rest it is the smooth step, whose peaks are  1.875 |D| / T  in velocity and  5.7735 |D| / T^2  in
// acceleration (15/8 and 10/sqrt(3)): the least T that keeps both limits is known at once. From a motion the
// peaks are found exactly, where the jerk (of degree 2) and the acceleration (of degree 3) vanish, and T by
// lengthening it step by step until they keep the limits and bisecting the last step: the limits are kept,
// and no T shorter by more than a step's quarter does. Where a_0 stands in the way (near the greatest
// velocity, still faster) the way begins without it, and there is always a T.
//
// A motion that is itself beyond the limits is let down within what it has: greater of limit and |v_0|.
// Allocates nothing; at most 64 + 16 trials.
//
// Where only the stand matters and not its place, the quintic of c_5 = 0, i.e. of
//
//   D = v_0 T / 2 + a_0 T^2 / 12,      v(s) = v_0 (1 - 3 s^2 + 2 s^3) + a_0 T (s - 2 s^2 + s^3)
//
// is a braking. From a_0 = 0 it decelerates by at most 1.5 |v_0| / T, is never faster than |v_0|, and goes on
// by 0.75 v_0^2 / a where it keeps the acceleration a.
#pragma once

#include <array>
#include <limits>
#include <optional>

#include "controller/reference/shape.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

/// What a transition keeps. Infinite: unlimited.
struct ReferenceLimits {
  double slew_um_per_s = std::numeric_limits<double>::infinity();
  double acceleration_um_per_s2 = std::numeric_limits<double>::infinity();
};
/// The smaller of each.
ReferenceLimits tighter(const ReferenceLimits& a, const ReferenceLimits& b);

class Transition {
 public:
  /// Of no duration, to 0.
  Transition() = default;
  /// Of exactly `duration_s`, whatever its peaks.
  Transition(const Motion& from, double to_um, double duration_s);

  /// The shortest that keeps the limits, but not shorter than `least_s`.
  static Transition within(const ReferenceLimits& limits, const Motion& from, double to_um, double least_s);
  /// The shortest braking to a stand that keeps the limits. The stand is in `range`: where the acceleration
  /// limit leaves no room for that, it brakes harder. Of no duration where the acceleration is unlimited.
  static Transition to_stand(const ReferenceLimits& limits, const Motion& from, const model::Interval& range);

  double duration_s() const { return duration_s_; }
  double end_um() const { return to_um_; }
  double value_um(double t_s) const;
  Motion at(double t_s) const;

  double peak_slew_um_per_s() const;
  double peak_acceleration_um_per_s2() const;

 private:
  template <class Goal>
  static std::optional<Transition> shortest(const ReferenceLimits& kept, const Motion& begin, double least_s,
                                            const Goal& to_um);
  bool keeps(const ReferenceLimits& limits) const;
  std::array<double, 4> without_jerk() const;
  double slope(double s) const;      ///< dx/ds
  double curvature(double s) const;  ///< d2x/ds2

  std::array<double, 6> c_{};
  double to_um_ = 0.0;
  double duration_s_ = 0.0;
};

}  // namespace hystcan::controller
