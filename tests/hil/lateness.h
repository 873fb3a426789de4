// How late the cycles of a run were, by what that did to its tracking. A loop of a quarter of a percent feels
// 10 us as 2 % of its error; so a bound is a time, not a share of an error that every better tuning makes
// smaller.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace hystcan::hil {

/// Of the triangles in config/piezo.toml, axes x and y.
inline constexpr std::array shipped_speeds_um_per_s{480.0, 200.0};

/// Without a real-time class a kernel may wake a thread up by its timer slack of 50 us late.
inline constexpr double timer_slack_s = 50e-6;

/// By how much a stage at `speed_um_per_s` must be late to make `rms_um` of `expected_um`: the two errors are
/// independent of each other.
inline double lateness_s(double rms_um, double expected_um, double speed_um_per_s) {
  return std::sqrt(std::max(0.0, rms_um * rms_um - expected_um * expected_um)) / speed_um_per_s;
}

}  // namespace hystcan::hil
