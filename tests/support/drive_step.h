// How large a step of the drive a change of the running configuration may make.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace hystcan::support {

/// The drive's largest step from one cycle to the next is the reference's own: the way into a new reference
/// is never faster than what it leaves, or than its transition. Structures differ in the slope of their
/// feed-forward by the width of the hysteresis loop, 15 %; the same again for what PI adds and for a cycle
/// that is late.
inline constexpr double fair_share_of_own_step = 1.3;

/// The largest change from one value to the next; 0 of fewer than two.
inline double largest_step(const std::vector<double>& values) {
  double largest = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i)
    largest = std::max(largest, std::abs(values[i] - values[i - 1]));
  return largest;
}

}  // namespace hystcan::support
