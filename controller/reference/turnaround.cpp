#include "controller/reference/turnaround.h"

#include <algorithm>
#include <cmath>

namespace hystcan::controller {
namespace {

/// The least length of a pulse, as a share of the turnaround: the acceleration stays finite.
constexpr double least_pulse = 0.125;

/// The corner |t| and its first three antiderivatives.
double corner_slope(double t) { return t < 0.0 ? -1.0 : 1.0; }
double once(double t) { return 0.5 * t * std::abs(t); }
double twice(double t) { return t * t * std::abs(t) / 6.0; }

template <class Integral>
double mean(double t, double half, const Integral& integral) {
  return (integral(t + half) - integral(t - half)) / (2.0 * half);
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
  // The difference of two nearly equal integrals over a very short box would be rounding alone.
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

}  // namespace hystcan::controller
