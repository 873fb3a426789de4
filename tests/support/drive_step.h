// Limits the step of the drive that a change of the running configuration may cause.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace hystcan::support {

/// The largest allowed step of the drive at a change, relative to the largest step that the reference itself
/// causes: the transition to a new reference is never faster than the old reference or the transition limits.
/// The feed-forwards of two structures differ in slope by the width of the hysteresis loop, 15 %; another
/// 15 % are for PI and for a late cycle.
inline constexpr double fair_share_of_own_step = 1.3;

/// Returns the largest change between successive values; 0 for fewer than two values.
inline double largest_step(const std::vector<double>& values) {
  double largest = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i)
    largest = std::max(largest, std::abs(values[i] - values[i - 1]));
  return largest;
}

}  // namespace hystcan::support
