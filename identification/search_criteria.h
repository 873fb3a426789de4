// The numbers by which a search decides, and the measurement behind each. Measured: iron (BH curve), a wing
// of shape memory wires, PZT, a magnet, two piezo stages.
#pragma once

#include <cstddef>

namespace hystcan::identification {

/// Errors and scores (ShapeScore) are relative to their value without the change, unless a unit is given.
struct SearchCriteria {
  // An unknown is added if the error falls.
  double added = 0.97;            ///< maximum error; with 1, iron's held-out error is 15 % larger
  double added_held_out = 0.985;  ///< maximum held-out error: excludes unknowns that only follow noise
  /// Largest error after two fifths of the evaluations. Saves iron a fifth of the time, the wing a third;
  /// earlier ends cost 1 % of the error.
  double promising = 0.995;
  // One k replaces two.
  double one_k = 1.05;  ///< maximum error with one k, also held-out; costs a piezo stage 3 %

  // The shape of the curves.
  /// Order of the curves before k is known; with 8, a piezo stage has 3 % more error.
  int first_order = 5;
  double better_shape = 0.98;  ///< maximum score of a better shape, relative to the smallest score before
  int most_worse_shapes = 3;   ///< maximum consecutive shapes that are not better: even and odd orders differ
  /// Largest score, relative to the smallest: saves coefficients (order 7 instead of 8).
  double low_enough = 1.01;
  double exact =
      1e-6;  ///< a smaller score, in output spans, is exact: gives a noiseless record order 4, not 7
  /// A larger score, in output spans, restarts the search with splines. Without a restart, iron's error is
  /// 4.9 instead of 1.4 %; with a restart always, piezo stages take 2.5 times as long without benefit.
  double poor = 0.01;
  double hopeless_spline = 1.25;  ///< maximum score of splines before k is searched; halves the time of PZT
  double spline = 0.9;            ///< maximum score of a spline, which has more coefficients
  std::size_t usual_spline = 7;   ///< index of the first tried spline: 12 pieces
  /// Maximum score with an input map: wing 5.3 -> 2.3 %, iron 2.6 -> 1.4 %; the other records get none.
  double input_map = 0.9;

  // Limits of the trials.
  /// Another simplex search follows if the last one, which may have ended too early, has lowered the error at
  /// least to this factor.
  double restart = 0.99;
  double widest_k_span = 200.0;     ///< k times the span of the thresholds, or of a steep part
  double farthest_threshold = 3.0;  ///< distance beyond the inputs, in input spans
  double steep_part = 0.05;         ///< in input spans: a shorter piece of a spline is steep
};

inline constexpr SearchCriteria criteria;

}  // namespace hystcan::identification
