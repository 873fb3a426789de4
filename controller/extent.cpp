#include "controller/extent.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

namespace hystcan::controller {
namespace {

Extent between(double from_um, double to_um) {
  return {.lowest_um = std::min(from_um, to_um), .highest_um = std::max(from_um, to_um)};
}

/// A sine of this amplitude, in an envelope w that fades in `fade_s`: the length of the phasor of its
/// velocity, (w', w omega), and of its acceleration, (w'' - w omega^2, 2 w' omega + w omega').
void add_faded(Extent& extent, double amplitude_um, double frequency_Hz, double chirp_Hz_per_s,
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
  extent.peak_slew_um_per_s += amplitude_um * slew;
  extent.peak_acceleration_um_per_s2 += amplitude_um * acceleration;
}

Extent extent_of(const Hold& s) { return between(s.level_um, s.level_um); }
Extent extent_of(const Step& s) { return between(s.from_um, s.to_um); }

Extent extent_of(const Ramp& s) {
  Extent extent = between(s.from_um, s.to_um);
  extent.peak_slew_um_per_s = (extent.highest_um - extent.lowest_um) / s.duration_s;
  return extent;
}

Extent extent_of(const Triangle& s) {
  Extent extent = between(s.low_um, s.high_um);
  extent.peak_slew_um_per_s = 2.0 * s.frequency_Hz * (extent.highest_um - extent.lowest_um);
  return extent;
}

Extent extent_of(const Sine& s) {
  Extent extent = between(s.low_um, s.high_um);
  const double omega = 2.0 * std::numbers::pi * s.frequency_Hz;
  extent.peak_slew_um_per_s = 0.5 * omega * (extent.highest_um - extent.lowest_um);
  extent.peak_acceleration_um_per_s2 = omega * extent.peak_slew_um_per_s;
  return extent;
}

Extent extent_of(const Chirp& s) {
  Extent extent = between(s.low_um, s.high_um);
  add_faded(extent, 0.5 * (extent.highest_um - extent.lowest_um), std::max(s.from_Hz, s.to_Hz),
            (s.to_Hz - s.from_Hz) / s.duration_s, s.fade_s);
  return extent;
}

Extent bound_of(const MultiSine& s) {
  Extent extent = between(s.centre_um, s.centre_um);
  for (std::size_t k = 0; k < s.amplitudes_um.size(); ++k) {
    const double amplitude_um = std::abs(s.amplitudes_um[k]);
    extent.lowest_um -= amplitude_um;
    extent.highest_um += amplitude_um;
    add_faded(extent, amplitude_um, s.frequencies_Hz[k], 0.0, s.fade_s);
  }
  return extent;
}

Extent extent_of(const MultiSine& s) {
  constexpr double points_per_period = 64.0;
  constexpr double most_points = 1e6;
  const double length_s = duration_s(s);
  const double shortest_s = std::min(1.0 / std::ranges::max(s.frequencies_Hz), s.fade_s);
  const double points = std::ceil(points_per_period * length_s / shortest_s);
  if (points > most_points) return bound_of(s);
  Extent extent = between(s.centre_um, s.centre_um);
  for (int i = 0; i <= static_cast<int>(points); ++i) {
    const Motion at = motion(s, length_s * i / points);
    extent.lowest_um = std::min(extent.lowest_um, at.value_um);
    extent.highest_um = std::max(extent.highest_um, at.value_um);
    extent.peak_slew_um_per_s = std::max(extent.peak_slew_um_per_s, std::abs(at.velocity_um_per_s));
    extent.peak_acceleration_um_per_s2 =
        std::max(extent.peak_acceleration_um_per_s2, std::abs(at.acceleration_um_per_s2));
  }
  return extent;
}

Extent extent_of(const Staircase& s) {
  const auto [lowest, highest] = std::ranges::minmax(s.levels_um);
  Extent extent = between(lowest, highest);
  if (s.rise_s == 0.0) return extent;
  for (std::size_t i = 1; i < s.levels_um.size(); ++i) {
    const double height_um = std::abs(s.levels_um[i] - s.levels_um[i - 1]);
    extent.peak_slew_um_per_s =
        std::max(extent.peak_slew_um_per_s, smooth_step_peak_slope * height_um / s.rise_s);
    extent.peak_acceleration_um_per_s2 = std::max(
        extent.peak_acceleration_um_per_s2, smooth_step_peak_curvature * height_um / (s.rise_s * s.rise_s));
  }
  return extent;
}

Extent extent_of(const Table& s) {
  const MonotoneCubic::Extent curve = s.curve.extent();
  return {curve.lowest, curve.highest, curve.peak_slope, curve.peak_curvature};
}

}  // namespace

Extent extent(const Shape& shape) {
  return std::visit([](const auto& s) { return extent_of(s); }, shape);
}

}  // namespace hystcan::controller
