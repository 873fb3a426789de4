// A smooth transition from any motion to rest: a polynomial of degree 5 with minimum jerk.
//
//   s               time since the beginning as a share of the duration T, s = t / T
//   x_0, v_0, a_0   position, velocity and acceleration at the beginning
//   x_1             position at the end; velocity and acceleration are 0 there
//   D, c_1, c_2     D = x_1 - x_0,  c_1 = v_0 T,  c_2 = a_0 T^2 / 2
//
//   x(s) = x_0 + c_1 s + c_2 s^2 + (10 D - 6 c_1 - 3 c_2) s^3 + (8 c_1 + 3 c_2 - 15 D) s^4
//          + (6 D - 3 c_1 - c_2) s^5
//
// If the transition begins at rest, x(s) is the smooth step (motion.h). Its peaks give the smallest T that
// keeps the limits of velocity and acceleration:
//
//   max |v| = (15 / 8) |D| / T = 1.875 |D| / T,      max |a| = (10 / sqrt(3)) |D| / T^2 = 5.7735 |D| / T^2
//
// If the transition begins in motion, the acceleration has its peak at a zero of the jerk, and the velocity
// at a zero of the acceleration. The jerk is a polynomial of degree 2; the acceleration is 1 - s times a
// polynomial of degree 2. A search increases T step by step until both peaks keep their limits, and then
// bisects the last step. If no T is long enough because of a_0 (near the maximum velocity and still
// accelerating), the transition begins with a_0 = 0; then there always is a T.
//
// If |v_0| is already above the limit of velocity, |v_0| is used as the limit. The search allocates nothing
// and makes at most 64 + 64 + 16 trials.
//
// A braking is a transition that may stop at any position. Its polynomial has no term of degree 5:
//
//   D = v_0 T / 2 + a_0 T^2 / 12,      v(s) = v_0 (1 - 3 s^2 + 2 s^3) + a_0 T (s - 2 s^2 + s^3)
//
// With a_0 = 0, a braking decelerates by at most 1.5 |v_0| / T and is never faster than |v_0|. If it
// decelerates by at most a, it needs the distance 0.75 v_0^2 / a.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "controller/reference/shape.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

/// Maximum velocity and maximum acceleration of a reference or of a transition. An infinite value is no
/// limit.
struct ReferenceLimits {
  double slew_um_per_s = std::numeric_limits<double>::infinity();
  double acceleration_um_per_s2 = std::numeric_limits<double>::infinity();
};
/// Returns the smaller velocity limit and the smaller acceleration limit of `a` and `b`.
ReferenceLimits tighter(const ReferenceLimits& a, const ReferenceLimits& b);

class Transition {
 public:
  /// Constructs a transition of duration 0 that ends at the position 0.
  Transition() = default;
  /// Constructs a transition of exactly `duration_s`. Its velocity and its acceleration are not limited.
  Transition(const Motion& from, double to_um, double duration_s);

  /// Returns the shortest transition that keeps the limits and lasts at least `least_s`.
  static Transition within(const ReferenceLimits& limits, const Motion& from, double to_um, double least_s);
  /// Returns the shortest braking to rest that keeps the limits and ends in `range`. If `range` is too short
  /// for the limit of acceleration, the braking exceeds this limit. If the acceleration is unlimited, the
  /// braking has the duration 0.
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
  double slope(double s) const;      ///< derivative of the position by s, the elapsed share of the duration
  double curvature(double s) const;  ///< second derivative of the position by the elapsed share s

  std::array<double, 6> c_{};
  double to_um_ = 0.0;
  double duration_s_ = 0.0;
};

// The handover from one reference to the next, without a jump of the drive. It has three parts:
//
//   from t_0, for h    lead: the old reference, unchanged. t_0 is the beginning of the handover, and h is the
//                      time by which the feed-forward looks ahead
//   then for T_b       braking to rest from the motion of the old reference (Transition::to_stand)
//   then for T         onward: a Transition from rest to the goal
//
// The lead is necessary because the feed-forward of an actuator with the mean delay mu uses r(t + mu), the
// reference in the future. At t_0 the drive already follows the old reference up to t_0 + mu. If a new
// reference began at t_0, the feed-forward would jump by
//
//   |r_new(t_0 + mu) - r_old(t_0 + mu)|
//
// The jump is up to mu |v| if the reference stops from the velocity v, and up to 2 mu |v| if it turns. No
// limit of slew or acceleration prevents this jump. With the lead, the drive moves as smoothly as the
// reference.
//
// The lead is stored as points with straight lines between them, which rounds a corner over h / 32.

class Handover {
 public:
  static constexpr std::size_t lead_intervals = 32;
  using Lead = std::array<double, lead_intervals + 1>;

  /// Constructs a handover of duration 0 that ends at the position 0.
  Handover() = default;
  /// Constructs a handover that consists only of the transition to the goal, without lead and braking.
  explicit Handover(const Transition& onward) : onward_(onward) {}
  /// `lead`: positions of the old reference in um, at equal time steps within `lead_s`. It is ignored if
  /// `lead_s` is 0.
  Handover(const Lead& lead, double lead_s, const Transition& braking, const Transition& onward)
      : lead_(lead), lead_s_(lead_s), braking_(braking), onward_(onward) {}

  double duration_s() const { return lead_s_ + braking_.duration_s() + onward_.duration_s(); }
  /// Returns the position `t_s` seconds after the beginning of the handover. Before the beginning, this is
  /// the first position; after the end, it is the goal.
  double value_um(double t_s) const;
  Motion at(double t_s) const;

 private:
  Lead lead_{};
  double lead_s_ = 0.0;
  Transition braking_;
  Transition onward_;
};

}  // namespace hystcan::controller
