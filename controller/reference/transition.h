// A smooth transition from a motion to rest: the quintic x(s) with minimum jerk, s = t / T, between (x_0,
// v_0, a_0) and (x_1, 0, 0), with D = x_1 - x_0, c_1 = v_0 T, c_2 = a_0 T^2 / 2:
//
//   x(s) = x_0 + c_1 s + c_2 s^2 + (10 D - 6 c_1 - 3 c_2) s^3 + (8 c_1 + 3 c_2 - 15 D) s^4
//          + (6 D - 3 c_1 - c_2) s^5
//
// From rest this is the smooth step. Its peaks give the smallest T that keeps both limits:
//
//   max |v| = (15 / 8) |D| / T = 1.875 |D| / T,      max |a| = (10 / sqrt(3)) |D| / T^2 = 5.7735 |D| / T^2
//
// From a motion, the peaks are at the zeros of the jerk (of degree 2) and of the acceleration (1 - s times a
// polynomial of degree 2). T is increased step by step until the peaks keep the limits, and the last step is
// bisected. If a_0 makes this impossible (near the maximum velocity and still accelerating), the transition
// begins without a_0; then there always is a T.
//
// If the present velocity is itself beyond its limit, |v_0| is used as the limit. Nothing is allocated; there
// are at most 64 + 64 + 16 trials.
//
// If the transition only has to stop, at any place, the quintic with c_5 = 0 is a braking:
//
//   D = v_0 T / 2 + a_0 T^2 / 12,      v(s) = v_0 (1 - 3 s^2 + 2 s^3) + a_0 T (s - 2 s^2 + s^3)
//
// From a_0 = 0 it decelerates by at most 1.5 |v_0| / T and is never faster than |v_0|. With the acceleration
// a it needs the distance 0.75 v_0^2 / a.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "controller/reference/shape.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

/// Limits of a transition; infinite: unlimited.
struct ReferenceLimits {
  double slew_um_per_s = std::numeric_limits<double>::infinity();
  double acceleration_um_per_s2 = std::numeric_limits<double>::infinity();
};
/// Returns for each kind of limit the smaller one of `a` and `b`.
ReferenceLimits tighter(const ReferenceLimits& a, const ReferenceLimits& b);

class Transition {
 public:
  /// Constructs a transition without duration that ends at 0.
  Transition() = default;
  /// Lasts exactly `duration_s`, whatever its peaks are.
  Transition(const Motion& from, double to_um, double duration_s);

  /// Returns the shortest transition that keeps the limits and lasts at least `least_s`.
  static Transition within(const ReferenceLimits& limits, const Motion& from, double to_um, double least_s);
  /// Returns the shortest braking to rest that keeps the limits and ends in `range`. If the limit of
  /// acceleration leaves too little room, the braking is harder. It has no duration if the acceleration is
  /// unlimited.
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
  double slope(double s) const;      ///< dx/ds
  double curvature(double s) const;  ///< d2x/ds2

  std::array<double, 6> c_{};
  double to_um_ = 0.0;
  double duration_s_ = 0.0;
};

// The handover from one reference to the next, without a jump of the drive.
//
//   t_0 .. t_0 + h    lead: the old reference, unchanged
//   .. + T_b          braking to rest, from the motion at t_0 + h (Transition::to_stand)
//   .. + T            onward: from rest to the goal (Transition)
//
// h is the preview. The feed-forward of a chain of delay mu uses r(t + mu): at t_0 the drive already follows
// the old reference up to t_0 + mu. A new reference that began at t_0 would make the feed-forward jump by
//
//   |r_new(t_0 + mu) - r_old(t_0 + mu)|:   up to mu |v| after a stop, up to 2 mu |v| before a corner
//
// whatever the limits of slew and acceleration are. From t_0 + h on, the drive moves as smoothly as the
// reference.
//
// The lead is stored as points with straight lines between them, which rounds a corner over h / 32.

class Handover {
 public:
  static constexpr std::size_t lead_intervals = 32;
  using Lead = std::array<double, lead_intervals + 1>;

  /// Constructs a handover without duration that ends at 0.
  Handover() = default;
  /// Constructs a handover without lead and braking.
  explicit Handover(const Transition& onward) : onward_(onward) {}
  /// `lead`: points in um at equal intervals of lead_s; ignored if lead_s is 0.
  Handover(const Lead& lead, double lead_s, const Transition& braking, const Transition& onward)
      : lead_(lead), lead_s_(lead_s), braking_(braking), onward_(onward) {}

  double duration_s() const { return lead_s_ + braking_.duration_s() + onward_.duration_s(); }
  /// `t_s` counts from the beginning. Before t_s = 0 the value is the first one; after the end it is the
  /// goal.
  double value_um(double t_s) const;
  Motion at(double t_s) const;

 private:
  Lead lead_{};
  double lead_s_ = 0.0;
  Transition braking_;
  Transition onward_;
};

}  // namespace hystcan::controller
