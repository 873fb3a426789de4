// Designs the filter with which a loop learns (controller/control/learning.h).
//
// The learnt correction is added to the reference of PI and, m whole cycles ahead, to the feed-forward. The
// loop responds to the correction with T:
//
//   T = P (z^m + PI F) / (1 + L)
//   T = L / (1 + L)    without feed-forward: structure `pi` of the control law
//   T = P z^m          without PI: structures `average` and `inverse`
//
//   P, PI, F, L    plant with notch, PI, low pass and open loop (linear_loop.h)
//   z, m           z: shift by one cycle; m: time that the feed-forward looks ahead, in whole cycles
//   H              response of the filter that turns an error into a correction
//   M, R           middle and radius of a disc that contains T for every resonance in its interval
//   q              share of the error that may be learnt: smaller if the phase of T is more uncertain
//
// The regularised inverse of M learns best for all resonances in the interval:
//
//   H = q conj(M) / (|M|^2 + 0.02),   q = max(0, 1 - R / |M|)^2
//
// A window makes H a filter of finite length. A check uses this finite filter, for every T and every
// frequency:
//
//   |1 - forget - rate H T| <= 1 - forget / 2         rate, forget: Learning::Config
//
// If the check fails, a low pass cuts H off, and its corner decreases until the check passes. If the period
// is short, several periods are learnt together, because this allows a longer filter.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "controller/analysis/linear_loop.h"
#include "controller/control/axis.h"

namespace hystcan::controller {

struct LearningDesign {
  Learning::Plan plan;
  /// Number of periods that form one block. Learning has one correction for each cycle of the block. One
  /// period may not be a whole number of cycles, but the block nearly is.
  unsigned periods = 1;
  /// Difference between `periods` periods and a whole number of cycles. Because of this difference,
  /// corrections are interpolated between cycles.
  double slip_cycles = 0.0;
  /// Frequency up to which an error falls to a tenth within 20 periods at the default learning rate. With a
  /// lower learning rate, more periods are allowed.
  double highest_Hz = 0.0;
  double slowest_Hz = 0.0;       ///< frequency below highest_Hz at which learning is slowest
  double slowest_periods = 0.0;  ///< periods until the error at slowest_Hz has fallen to a tenth
  /// Largest factor by which an error changes from one period to the next, over all resonances and
  /// frequencies.
  double largest_growth = 0.0;
  double resonance_percent = 0.0;
};

/// Returns the period of a shape in s; `nullopt` if the shape does not repeat.
std::optional<double> period_s(const Shape& shape);

/// Longest period that a loop can learn, in cycles.
inline constexpr double longest_period_cycles = 20'000.0;

/// Designs the learning filter for one segment. Throws std::invalid_argument if the period has fewer than 4
/// cycles or more than longest_period_cycles, if the segment has too few periods, or if no filter converges.
LearningDesign design_learning(const LoopConfig& loop, const Shape& shape, const Learning::Config& config);

/// If the axis learns, completes its Learning::Config: sets `ahead_cycles`, by which the feed-forward uses a
/// correction early, and designs the learning filter in `plans` for each segment that repeats. Returns the
/// design of each segment; `nullopt` for the others. Throws std::invalid_argument if no segment repeats, or
/// if design_learning() throws.
std::vector<std::optional<LearningDesign>> plan_learning(AxisConfig& axis, double rate_Hz);

}  // namespace hystcan::controller
