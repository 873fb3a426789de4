// Designs the filter with which a loop learns (controller/control/learning.h).
//
// The correction is added m whole cycles ahead to the feed-forward, and to the reference of PI:
//
//   T = P (z^m + PI F) / (1 + L)                    linear_loop.h; m: the preview, rounded
//   T = L / (1 + L)  without feed-forward (pi),     T = P z^m  without PI (average, inverse)
//
// For every resonance in its interval, T is inside a disc with the middle M and the radius R. The regularised
// inverse of M learns best for all of them. The larger the uncertainty of the phase, the smaller is q:
//
//   H = q conj(M) / (|M|^2 + 0.02),   q = max(0, 1 - R / |M|)^2
//
// A window makes H a filter of finite length. The check uses this finite filter, for every T and every theta:
//
//   |1 - forget - rate H T| <= 1 - forget / 2
//
// If the check fails, a low pass with a decreasing corner cuts H off until the check passes. If the period is
// short, several periods are also learnt together, which allows a longer filter.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "controller/analysis/linear_loop.h"
#include "controller/control/axis.h"

namespace hystcan::controller {

struct LearningDesign {
  Learning::Plan plan;
  /// Periods that are learnt together, because together they are nearly a whole number of cycles.
  unsigned periods = 1;
  /// Difference of these periods from a whole number of cycles; the phases are interpolated.
  double slip_cycles = 0.0;
  /// Highest frequency at which the error falls to a tenth within 20 periods, at the default rate.
  double highest_Hz = 0.0;
  double slowest_Hz = 0.0;       ///< frequency below highest_Hz at which learning is slowest
  double slowest_periods = 0.0;  ///< periods until the error at slowest_Hz has fallen to a tenth
  double largest_growth = 0.0;   ///< largest |1 - forget - rate H T| over resonances and frequencies
  double resonance_percent = 0.0;
};

/// Returns the period of a shape; `nullopt` if the shape does not repeat.
std::optional<double> period_s(const Shape& shape);

/// Longest period, in cycles.
inline constexpr double longest_period_cycles = 20'000.0;

/// Designs the filter of one segment. Throws std::invalid_argument if the period has fewer than 4 cycles or
/// more than longest_period_cycles, or if no filter converges.
LearningDesign design_learning(const LoopConfig& loop, const Shape& shape, const Learning::Config& config);

/// Designs ahead_cycles and plans for the axis's learning, if it has one, for each segment that repeats.
/// Throws std::invalid_argument if no segment repeats, or if design_learning does.
std::vector<std::optional<LearningDesign>> plan_learning(AxisConfig& axis, double rate_Hz);

}  // namespace hystcan::controller
