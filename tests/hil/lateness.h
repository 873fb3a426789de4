// Computes the lateness of a run's cycles from the tracking error that it caused. For a loop with an error of
// a quarter of a percent, 10 us add 2 % to the error. The bound is therefore a time: a share of the error
// would change with every better tuning.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace hystcan::hil {

/// Speeds of the triangles in config/piezo.toml, axes x and y.
inline constexpr std::array shipped_speeds_um_per_s{480.0, 200.0};

/// Without a real-time class, the kernel may wake a thread 50 us late (its timer slack).
inline constexpr double timer_slack_s = 50e-6;

/// Returns the lateness that changes the error from `expected_um` to `rms_um` at `speed_um_per_s`. The two
/// errors are assumed to be independent.
inline double lateness_s(double rms_um, double expected_um, double speed_um_per_s) {
  return std::sqrt(std::max(0.0, rms_um * rms_um - expected_um * expected_um)) / speed_um_per_s;
}

}  // namespace hystcan::hil
