#include "controller/reference/motion_bounds.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

namespace hystcan::controller {
namespace {

MotionBounds between(double from_um, double to_um) {
  return {.lowest_um = std::min(from_um, to_um), .highest_um = std::max(from_um, to_um)};
}

/// Phasor lengths of a sine of this amplitude in an envelope w that fades within `fade_s`:
///   velocity      (w', w omega)
///   acceleration  (w'' - w omega^2, 2 w' omega + w omega')
void add_faded(MotionBounds& bounds, double amplitude_um, double frequency_Hz, double chirp_Hz_per_s,
               double fade_s) {
  constexpr int points = 500;
  const double omega = 2.0 * std::numbers::pi * frequency_Hz;
  const double omega_change = 2.0 * std::numbers::pi * std::abs(chirp_Hz_per_s);
  double slew = 0.0;
  double acceleration = 0.0;
  for (int i = 0; i <= points; ++i) {
    const double s = static_cast<double>(i) / points;
    const double w = smooth_step(s);
    const double slope = 30.0 * s * s * (1.0 - s) * (1.0 - s) / fade_s;
    const double curvature = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (fade_s * fade_s);
    slew = std::max(slew, std::hypot(slope, w * omega));
    acceleration = std::max(
        acceleration, std::hypot(curvature - w * omega * omega, 2.0 * slope * omega + w * omega_change));
  }
  bounds.peak_slew_um_per_s += amplitude_um * slew;
  bounds.peak_acceleration_um_per_s2 += amplitude_um * acceleration;
}

MotionBounds motion_bounds_of(const Hold& s) { return between(s.level_um, s.level_um); }
MotionBounds motion_bounds_of(const Step& s) { return between(s.from_um, s.to_um); }

MotionBounds motion_bounds_of(const Ramp& s) {
  MotionBounds bounds = between(s.from_um, s.to_um);
  bounds.peak_slew_um_per_s = (bounds.highest_um - bounds.lowest_um) / s.duration_s;
  return bounds;
}

MotionBounds motion_bounds_of(const Triangle& s) {
  MotionBounds bounds = between(s.low_um, s.high_um);
  bounds.peak_slew_um_per_s = 2.0 * s.frequency_Hz * (bounds.highest_um - bounds.lowest_um);
  if (s.turnaround_percent == 0.0) return bounds;
  const Sawtooth wave = rounded(s);
  bounds.peak_slew_um_per_s = wave.peak_slew_um_per_s();
  bounds.peak_acceleration_um_per_s2 = wave.peak_acceleration_um_per_s2();
  return bounds;
}

MotionBounds motion_bounds_of(const Raster& s) {
  MotionBounds bounds = between(s.low_um, s.high_um);
  const Motion peak = peak_motion(s);
  bounds.peak_slew_um_per_s = peak.velocity_um_per_s;
  bounds.peak_acceleration_um_per_s2 = peak.acceleration_um_per_s2;
  return bounds;
}

MotionBounds motion_bounds_of(const Sine& s) {
  MotionBounds bounds = between(s.low_um, s.high_um);
  const double omega = 2.0 * std::numbers::pi * s.frequency_Hz;
  bounds.peak_slew_um_per_s = 0.5 * omega * (bounds.highest_um - bounds.lowest_um);
  bounds.peak_acceleration_um_per_s2 = omega * bounds.peak_slew_um_per_s;
  return bounds;
}

MotionBounds motion_bounds_of(const Chirp& s) {
  MotionBounds bounds = between(s.low_um, s.high_um);
  add_faded(bounds, 0.5 * (bounds.highest_um - bounds.lowest_um), std::max(s.from_Hz, s.to_Hz),
            (s.to_Hz - s.from_Hz) / s.duration_s, s.fade_s);
  return bounds;
}

MotionBounds bound_of(const MultiSine& s) {
  MotionBounds bounds = between(s.centre_um, s.centre_um);
  for (std::size_t k = 0; k < s.amplitudes_um.size(); ++k) {
    const double amplitude_um = std::abs(s.amplitudes_um[k]);
    bounds.lowest_um -= amplitude_um;
    bounds.highest_um += amplitude_um;
    add_faded(bounds, amplitude_um, s.frequencies_Hz[k], 0.0, s.fade_s);
  }
  return bounds;
}

MotionBounds motion_bounds_of(const MultiSine& s) {
  constexpr double points_per_period = 64.0;
  constexpr double most_points = 1e6;
  const double length_s = duration_s(s);
  const double shortest_s = std::min(1.0 / std::ranges::max(s.frequencies_Hz), s.fade_s);
  const double points = std::ceil(points_per_period * length_s / shortest_s);
  if (points > most_points) return bound_of(s);
  MotionBounds bounds = between(s.centre_um, s.centre_um);
  for (int i = 0; i <= static_cast<int>(points); ++i) {
    const Motion at = motion(s, length_s * i / points);
    bounds.lowest_um = std::min(bounds.lowest_um, at.value_um);
    bounds.highest_um = std::max(bounds.highest_um, at.value_um);
    bounds.peak_slew_um_per_s = std::max(bounds.peak_slew_um_per_s, std::abs(at.velocity_um_per_s));
    bounds.peak_acceleration_um_per_s2 =
        std::max(bounds.peak_acceleration_um_per_s2, std::abs(at.acceleration_um_per_s2));
  }
  return bounds;
}

MotionBounds motion_bounds_of(const Staircase& s) {
  const auto [lowest, highest] = std::ranges::minmax(s.levels_um);
  MotionBounds bounds = between(lowest, highest);
  if (s.rise_s == 0.0) return bounds;
  for (std::size_t i = 1; i < s.levels_um.size(); ++i) {
    const double height_um = std::abs(s.levels_um[i] - s.levels_um[i - 1]);
    bounds.peak_slew_um_per_s =
        std::max(bounds.peak_slew_um_per_s, smooth_step_peak_slope * height_um / s.rise_s);
    bounds.peak_acceleration_um_per_s2 = std::max(
        bounds.peak_acceleration_um_per_s2, smooth_step_peak_curvature * height_um / (s.rise_s * s.rise_s));
  }
  return bounds;
}

MotionBounds motion_bounds_of(const Table& s) {
  const MonotoneCubic::Range curve = s.curve.range();
  return {curve.lowest, curve.highest, curve.peak_slope, curve.peak_curvature};
}

}  // namespace

MotionBounds motion_bounds(const Shape& shape) {
  return std::visit([](const auto& s) { return motion_bounds_of(s); }, shape);
}

}  // namespace hystcan::controller
