// The filter with which a loop learns (controller/control/learning.h).
//
// The correction goes m whole cycles ahead into the feed-forward, and into what PI compares with:
//
//   T = P (z^m + PI F) / (1 + L)                    linear_loop.h; m: the preview, rounded
//   T = L / (1 + L)  without feed-forward (pi),     T = P z^m  without PI (average, inverse)
//
// With the resonance anywhere in its interval, T lies within a disc of middle M and radius R. The inverse of
// the middle, regularised, learns best from all of them; the more it must doubt the phase, the less it
// learns:
//
//   H = q conj(M) / (|M|^2 + 0.02),   q = max(0, 1 - R / |M|)^2
//
// H is made a filter of finite length by a window. What is checked is the filter as it is, for every T and
// every theta:
//
//   |1 - forget - rate H T| <= 1 - forget / 2
//
// Where this does not hold, H is cut off by a low pass with a lower and lower corner until it does; for a
// short period also with several periods learnt together, which allows a longer filter.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "controller/analysis/linear_loop.h"
#include "controller/control/axis.h"

namespace hystcan::controller {

struct LearningDesign {
  Learning::Plan plan;
  unsigned periods = 1;      ///< learnt together, because they are a whole number of cycles, or nearly
  double slip_cycles = 0.0;  ///< what they are off from it: the phases are interpolated
  double highest_Hz = 0.0;   ///< up to here an error falls to a tenth within 20 periods, at the default rate
  double slowest_Hz = 0.0;   ///< the frequency below it that is learnt slowest
  double slowest_periods = 0.0;  ///< until its error is a tenth
  double largest_growth = 0.0;   ///< the largest |1 - forget - rate H T| over resonances and frequencies
  double resonance_percent = 0.0;
};

/// The period of a shape that repeats; empty: it does not.
std::optional<double> period_s(const Shape& shape);

/// The longest period, in cycles.
inline constexpr double longest_period_cycles = 20'000.0;

/// Designs the filter of one segment. Throws std::invalid_argument where the period has fewer than 4 cycles
/// or more than longest_period_cycles, or where no filter converges.
LearningDesign design_learning(const LoopConfig& loop, const Shape& shape, const Learning::Config& config);

/// Fills ahead_cycles and plans of the axis's learning, if it has one, for each segment that repeats. Throws
/// std::invalid_argument where no segment repeats, or as design_learning.
std::vector<std::optional<LearningDesign>> plan_learning(AxisConfig& axis, double rate_Hz);

}  // namespace hystcan::controller
