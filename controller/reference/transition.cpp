#include "controller/reference/transition.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace hystcan::controller {
namespace {

/// Factor by which a peak may exceed its limit. Because of rounding, a transition exactly at its limit would
/// otherwise be rejected.
constexpr double slack = 1.0 + 1e-9;

bool is_rest(const Motion& motion) {
  return motion.velocity_um_per_s == 0.0 && motion.acceleration_um_per_s2 == 0.0;
}

/// Returns the shortest duration of a smooth step over `distance_um` that keeps the limits.
double least_duration_s(const ReferenceLimits& limits, double distance_um) {
  return std::max(smooth_step_peak_slope * distance_um / limits.slew_um_per_s,
                  std::sqrt(smooth_step_peak_curvature * distance_um / limits.acceleration_um_per_s2));
}

/// Returns the limits for a transition that begins with the motion `from`. If `from` is faster than the
/// velocity limit, its velocity replaces this limit.
ReferenceLimits kept_from(const ReferenceLimits& limits, const Motion& from) {
  return {.slew_um_per_s = std::max(limits.slew_um_per_s, std::abs(from.velocity_um_per_s)),
          .acceleration_um_per_s2 = limits.acceleration_um_per_s2};
}

Motion without_acceleration(const Motion& motion) {
  return {.value_um = motion.value_um, .velocity_um_per_s = motion.velocity_um_per_s};
}

/// Returns the position at which the stage comes to rest if it brakes from the motion `from` in `duration_s`.
double stand_um(const Motion& from, double duration_s) {
  return from.value_um +
         duration_s * (from.velocity_um_per_s / 2.0 + duration_s * from.acceleration_um_per_s2 / 12.0);
}

/// Returns the two roots of p0 + p1 s + p2 s^2, each limited to the interval 0 .. 1. Without two real roots,
/// returns zeros.
std::array<double, 2> roots_within_the_way(double p0, double p1, double p2) {
  const double discriminant = p1 * p1 - 4.0 * p2 * p0;
  if (!(discriminant > 0.0)) return {};
  // The roots are q / p2 and p0 / q. The two terms in the bracket of q have the same sign, so that their sum
  // loses no digits.
  const double q = -0.5 * (p1 + std::copysign(std::sqrt(discriminant), p1));
  return {std::clamp(q / p2, 0.0, 1.0), std::clamp(p0 / q, 0.0, 1.0)};
}

}  // namespace

ReferenceLimits tighter(const ReferenceLimits& a, const ReferenceLimits& b) {
  return {.slew_um_per_s = std::min(a.slew_um_per_s, b.slew_um_per_s),
          .acceleration_um_per_s2 = std::min(a.acceleration_um_per_s2, b.acceleration_um_per_s2)};
}

Transition::Transition(const Motion& from, double to_um, double duration_s)
    : to_um_(to_um), duration_s_(duration_s) {
  const double d = to_um - from.value_um;
  const double c1 = from.velocity_um_per_s * duration_s;
  const double c2 = 0.5 * from.acceleration_um_per_s2 * duration_s * duration_s;
  c_ = {from.value_um,          c1, c2, 10.0 * d - 6.0 * c1 - 3.0 * c2, 8.0 * c1 + 3.0 * c2 - 15.0 * d,
        6.0 * d - 3.0 * c1 - c2};
}

Transition Transition::within(const ReferenceLimits& limits, const Motion& from, double to_um,
                              double least_s) {
  const double distance_um = std::abs(to_um - from.value_um);
  const double from_rest_s = std::max(least_s, least_duration_s(limits, distance_um));
  if (is_rest(from)) return {from, to_um, from_rest_s};
  const ReferenceLimits kept = kept_from(limits, from);
  const auto search = [&](const Motion& begin) {
    // Lower limit of the duration: a transition cannot be shorter than a motion with the maximum velocity all
    // the way.
    return shortest(kept, begin, std::max(least_s, distance_um / kept.slew_um_per_s),
                    [&](double) { return to_um; });
  };
  if (const auto found = search(from)) return *found;
  const Motion at_constant_velocity = without_acceleration(from);
  if (const auto found = search(at_constant_velocity)) return *found;
  return {at_constant_velocity, to_um, from_rest_s};  // only if absurd numbers made both searches fail
}

Transition Transition::to_stand(const ReferenceLimits& limits, const Motion& from,
                                const model::Interval& range) {
  const Transition at_once({.value_um = from.value_um}, from.value_um, 0.0);
  if (is_rest(from) || std::isinf(limits.acceleration_um_per_s2)) return at_once;
  const ReferenceLimits kept = kept_from(limits, from);
  const auto search = [&](const Motion& begin) {
    return shortest(kept, begin, 0.0, [&](double duration_s) { return stand_um(begin, duration_s); });
  };
  const auto is_well = [&](const std::optional<Transition>& found) {
    return found && range.contains(found->end_um());
  };
  if (const auto found = search(from); is_well(found)) return *found;
  const Motion at_constant_velocity = without_acceleration(from);
  if (const auto found = search(at_constant_velocity); is_well(found)) return *found;
  const double room_um = from.velocity_um_per_s > 0.0 ? range.hi - from.value_um : from.value_um - range.lo;
  if (from.velocity_um_per_s == 0.0 || !(room_um > 0.0)) return at_once;
  const double duration_s = 2.0 * room_um / std::abs(from.velocity_um_per_s);
  return {at_constant_velocity, stand_um(at_constant_velocity, duration_s), duration_s};
}

/// Returns the shortest transition that keeps the limits and lasts at least `least_s`. Returns `nullopt` if
/// there is none. `to_um(duration_s)` is the end position of a transition of this duration.
template <class Goal>
std::optional<Transition> Transition::shortest(const ReferenceLimits& kept, const Motion& begin,
                                               double least_s, const Goal& to_um) {
  constexpr double growth = 1.25;
  constexpr int longer = 64;  // maximum number of steps; 1.25^64 is more than a million
  constexpr int halvings = 16;
  double too_short_s = 0.0;
  // Lower limit of the duration: the mean deceleration must not exceed the limit of acceleration.
  double duration_s =
      std::max({least_s, std::abs(begin.velocity_um_per_s) / kept.acceleration_um_per_s2, 1e-6});
  Transition found(begin, to_um(duration_s), duration_s);
  for (int i = 0; i < longer && !found.keeps(kept); ++i) {
    too_short_s = duration_s;
    duration_s *= growth;
    found = {begin, to_um(duration_s), duration_s};
  }
  if (!found.keeps(kept)) return std::nullopt;
  for (int i = 0; too_short_s > 0.0 && i < halvings; ++i) {
    const double middle_s = 0.5 * (too_short_s + duration_s);
    const Transition shorter(begin, to_um(middle_s), middle_s);
    (shorter.keeps(kept) ? duration_s : too_short_s) = middle_s;
    if (duration_s == middle_s) found = shorter;
  }
  return found;
}

double Transition::value_um(double t_s) const {
  if (!(t_s < duration_s_)) return to_um_;
  const double s = std::max(0.0, t_s / duration_s_);
  return c_[0] + s * (c_[1] + s * (c_[2] + s * (c_[3] + s * (c_[4] + s * c_[5]))));
}

Motion Transition::at(double t_s) const {
  if (!(t_s < duration_s_)) return {.value_um = to_um_};
  const double s = std::max(0.0, t_s / duration_s_);
  return {value_um(t_s), slope(s) / duration_s_, curvature(s) / (duration_s_ * duration_s_)};
}

double Transition::slope(double s) const {
  return c_[1] + s * (2.0 * c_[2] + s * (3.0 * c_[3] + s * (4.0 * c_[4] + s * 5.0 * c_[5])));
}

double Transition::curvature(double s) const {
  return 2.0 * c_[2] + s * (6.0 * c_[3] + s * (12.0 * c_[4] + s * 20.0 * c_[5]));
}

/// Returns the maximum acceleration: at the beginning, or at a zero of the jerk. The acceleration is 0 at the
/// end. The position is a polynomial in s, the elapsed share of the duration, with the coefficients c_k of
/// s^k. The third derivative of the position by s is
///
///   6 c_3 + 24 c_4 s + 60 c_5 s^2
double Transition::peak_acceleration_um_per_s2() const {
  if (duration_s_ <= 0.0) return 0.0;
  double peak = std::abs(curvature(0.0));
  for (const double s : roots_within_the_way(c_[3], 4.0 * c_[4], 10.0 * c_[5]))
    peak = std::max(peak, std::abs(curvature(s)));
  return peak / (duration_s_ * duration_s_);
}

/// Returns the maximum velocity: at the beginning, or at a zero of the acceleration. The velocity is 0 at the
/// end. One zero of the acceleration is at the end, s = 1. With the coefficients c_k of s^k in the position,
/// its other zeros are the roots of
///
///   curvature(s) / (1 - s) = 2 c_2 + (2 c_2 + 6 c_3) s - 20 c_5 s^2
double Transition::peak_slew_um_per_s() const {
  if (duration_s_ <= 0.0) return 0.0;
  double peak = std::abs(slope(0.0));
  for (const double s : roots_within_the_way(c_[2], c_[2] + 3.0 * c_[3], -10.0 * c_[5]))
    peak = std::max(peak, std::abs(slope(s)));
  return peak / duration_s_;
}

bool Transition::keeps(const ReferenceLimits& limits) const {
  const bool any_slew = std::isinf(limits.slew_um_per_s);
  const bool any_acceleration = std::isinf(limits.acceleration_um_per_s2);
  return (any_acceleration || peak_acceleration_um_per_s2() <= slack * limits.acceleration_um_per_s2) &&
         (any_slew || peak_slew_um_per_s() <= slack * limits.slew_um_per_s);
}

double Handover::value_um(double t_s) const { return at(t_s).value_um; }

Motion Handover::at(double t_s) const {
  t_s = std::max(0.0, t_s);
  if (t_s < lead_s_) {
    const double place = t_s / lead_s_ * lead_intervals;
    const auto i = static_cast<std::size_t>(place);
    const double rise_um = lead_[i + 1] - lead_[i];
    return {.value_um = lead_[i] + (place - static_cast<double>(i)) * rise_um,
            .velocity_um_per_s = rise_um * lead_intervals / lead_s_};
  }
  t_s -= lead_s_;
  if (t_s < braking_.duration_s()) return braking_.at(t_s);
  return onward_.at(t_s - braking_.duration_s());
}

}  // namespace hystcan::controller
