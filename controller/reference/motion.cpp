#include "controller/reference/motion.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace hystcan::controller {

double smooth_step(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
}

Motion smooth_rise(double from_um, double to_um, double t_s, double rise_s) {
  const double s = t_s / rise_s;
  if (!(s > 0.0)) return {.value_um = from_um};
  const double height_um = to_um - from_um;
  if (s >= 1.0) return {.value_um = from_um + height_um};
  return {.value_um = from_um + height_um * smooth_step(s),
          .velocity_um_per_s = height_um * (30.0 * s * s * (1.0 - s) * (1.0 - s) / rise_s),
          .acceleration_um_per_s2 = height_um * (60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (rise_s * rise_s))};
}

namespace {

/// Minimum length of a pulse of acceleration, as a share of the turnaround's duration. A shorter pulse would
/// need more acceleration.
constexpr double least_pulse = 0.125;

/// The corner |t|: its derivative, its first antiderivative once() and its second antiderivative twice().
double corner_slope(double t) { return t < 0.0 ? -1.0 : 1.0; }
double once(double t) { return 0.5 * t * std::abs(t); }
double twice(double t) { return t * t * std::abs(t) / 6.0; }

template <class Integral>
double mean(double t, double half, const Integral& integral) {
  return (integral(t + half) - integral(t - half)) / (2.0 * half);
}

/// Returns the time at which the turnaround has this slope. The slope never decreases, so bisection finds the
/// time.
double where_slope_is(const Turnaround& turnaround, double slope) {
  if (slope == 0.0) return 0.0;  // a turnaround is symmetric, so its slope is 0 at the time 0
  double before_s = -0.5 * turnaround.length_s();
  double after_s = -before_s;
  for (int i = 0; i < 60; ++i) {
    const double middle_s = 0.5 * (before_s + after_s);
    (turnaround.slope(middle_s) < slope ? before_s : after_s) = middle_s;
  }
  return 0.5 * (before_s + after_s);
}

bool finite(const std::vector<double>& values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

}  // namespace

Turnaround::Turnaround(double length_s, double mode_period_s) {
  if (length_s <= 0.0) return;
  if (length_s < mode_period_s) {
    const double pulse_s = std::max(length_s - 0.5 * mode_period_s, least_pulse * length_s);
    wide_s_ = 0.5 * pulse_s;
    apart_s_ = 0.5 * (length_s - pulse_s);
    return;
  }
  wide_s_ = 0.5 * std::max(mode_period_s, length_s - mode_period_s);
  narrow_s_ = 0.5 * length_s - wide_s_;
  // Omits the second rectangle (narrow_s_) if it is very short: the mean over it would be the difference of
  // two nearly equal integrals, which is only rounding error.
  if (narrow_s_ < 1e-6 * wide_s_) {
    wide_s_ = 0.5 * length_s;
    narrow_s_ = 0.0;
  }
}

template <class One>
double Turnaround::both(double t_s, const One& one) const {
  return apart_s_ == 0.0 ? one(t_s) : 0.5 * (one(t_s + apart_s_) + one(t_s - apart_s_));
}

double Turnaround::way_s(double t_s) const {
  if (std::abs(t_s) >= 0.5 * length_s()) return std::abs(t_s);
  const auto box = [this](double t) { return mean(t, wide_s_, once); };
  if (narrow_s_ == 0.0) return both(t_s, box);
  const auto integral = [this](double t) { return mean(t, wide_s_, twice); };
  return mean(t_s, narrow_s_, integral);
}

double Turnaround::slope(double t_s) const {
  if (std::abs(t_s) >= 0.5 * length_s()) return corner_slope(t_s);
  const auto box = [this](double t) { return mean(t, wide_s_, [](double s) { return std::abs(s); }); };
  if (narrow_s_ == 0.0) return both(t_s, box);
  const auto integral = [this](double t) { return mean(t, wide_s_, once); };
  return mean(t_s, narrow_s_, integral);
}

double Turnaround::curvature_per_s(double t_s) const {
  if (std::abs(t_s) >= 0.5 * length_s()) return 0.0;
  const auto box = [this](double t) { return std::abs(t) < wide_s_ ? 1.0 / wide_s_ : 0.0; };
  if (narrow_s_ == 0.0) return both(t_s, box);
  const auto slope_of_box = [this](double t) {
    return mean(t, wide_s_, [](double s) { return std::abs(s); });
  };
  return mean(t_s, narrow_s_, slope_of_box);
}

double Turnaround::peak_curvature_per_s() const {
  if (wide_s_ == 0.0) return 0.0;
  return (apart_s_ == 0.0 ? 1.0 : 0.5) / wide_s_;
}

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

/// Returns the time since the last lower corner of the line with sharp corners.
double Sawtooth::since_corner_s(double t_s) const {
  const double s = (t_s + lowest_s_) / period_s();
  return (s - std::floor(s)) * period_s();
}

/// Returns the motion around a corner of the sawtooth. `value_um`: position of the sharp corner. `t_s`: time
/// since the corner. `sign`: 1 for a lower corner, -1 for an upper one.
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

MonotoneCubic::MonotoneCubic(std::vector<double> x, std::vector<double> y)
    : x_(std::move(x)), y_(std::move(y)), slope_(x_.size(), 0.0) {
  if (x_.size() < 2 || x_.size() != y_.size())
    throw std::invalid_argument("the curve has " + std::to_string(x_.size()) + " values of x and " +
                                std::to_string(y_.size()) +
                                " values of y, expected at least two, and one y for each x");
  if (!finite(x_) || !finite(y_) || std::ranges::adjacent_find(x_, std::greater_equal{}) != x_.end())
    throw std::invalid_argument(
        "the curve's points are not in order, expected finite points with "
        "increasing x");
  const double first = x_.front();
  for (double& value : x_) value -= first;
  for (std::size_t i = 1; i + 1 < x_.size(); ++i) {
    const double before = x_[i] - x_[i - 1];
    const double after = x_[i + 1] - x_[i];
    const double d_before = (y_[i] - y_[i - 1]) / before;
    const double d_after = (y_[i + 1] - y_[i]) / after;
    if ((d_before > 0.0) != (d_after > 0.0) || d_before == 0.0 || d_after == 0.0) continue;
    slope_[i] =
        3.0 * (before + after) / ((2.0 * after + before) / d_before + (after + 2.0 * before) / d_after);
  }
}

Motion MonotoneCubic::at(double x) const {
  if (x_.empty()) return {};
  if (x < x_.front()) return {.value_um = y_.front()};
  if (x >= x_.back()) return {.value_um = y_.back()};
  const auto i = static_cast<std::size_t>(std::ranges::upper_bound(x_, x) - x_.begin() - 1);
  return on_piece(i, x - x_[i]);
}

/// Returns the motion on piece i of the curve, at the time u after its beginning: y_i + m_i u + c2 u^2 + c3
/// u^3. y_i and m_i are position and slope at the beginning of the piece. c2 and c3 are set so that position
/// and slope also agree at the end of the piece.
Motion MonotoneCubic::on_piece(std::size_t i, double u) const {
  const double h = x_[i + 1] - x_[i];
  const double d = (y_[i + 1] - y_[i]) / h;
  const double c2 = (3.0 * d - 2.0 * slope_[i] - slope_[i + 1]) / h;
  const double c3 = (slope_[i] + slope_[i + 1] - 2.0 * d) / (h * h);
  return {.value_um = y_[i] + u * (slope_[i] + u * (c2 + u * c3)),
          .velocity_um_per_s = slope_[i] + u * (2.0 * c2 + u * 3.0 * c3),
          .acceleration_um_per_s2 = 2.0 * c2 + 6.0 * c3 * u};
}

/// Returns the bounds of all pieces. The slope of a piece is a parabola, and its second derivative is linear.
/// So the maximum slope is at an end of the piece or at the zero of the second derivative.
MotionBounds MonotoneCubic::bounds() const {
  if (x_.empty()) return {};
  const auto [lowest, highest] = std::ranges::minmax(y_);
  MotionBounds bounds{.lowest_um = lowest, .highest_um = highest};
  const auto take = [&](const Motion& motion) {
    bounds.peak_slew_um_per_s = std::max(bounds.peak_slew_um_per_s, std::abs(motion.velocity_um_per_s));
    bounds.peak_acceleration_um_per_s2 =
        std::max(bounds.peak_acceleration_um_per_s2, std::abs(motion.acceleration_um_per_s2));
  };
  for (std::size_t i = 0; i + 1 < x_.size(); ++i) {
    const double h = x_[i + 1] - x_[i];
    const Motion begin = on_piece(i, 0.0);
    const Motion end = on_piece(i, h);
    take(begin);
    take(end);
    const double curved = begin.acceleration_um_per_s2;
    if ((curved > 0.0) != (end.acceleration_um_per_s2 > 0.0))
      take(on_piece(i, h * curved / (curved - end.acceleration_um_per_s2)));
  }
  return bounds;
}

}  // namespace hystcan::controller
