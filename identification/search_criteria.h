// The numbers that decide in a search, each with the measurement behind it. The measurements use six records:
// iron (BH curve), a wing of shape memory wires, PZT, a magnet, and two piezo stages.
#pragma once

#include <cstddef>

namespace hystcan::identification {

/// Limits for the decisions of a search. If no unit is given, an error or a score (ShapeScore) is relative: 1
/// is its value without the change that is tried.
struct SearchCriteria {
  // An unknown is added if both errors fall to the following limits.
  /// Maximum error with the unknown; with a limit of 1, the held-out error of the iron record is 15 % larger.
  double added = 0.97;
  /// Maximum held-out error with the unknown; excludes unknowns that only follow noise.
  double added_held_out = 0.985;
  /// Maximum error after two fifths of the evaluations; a trial above it ends there. Saves a fifth of the
  /// time for the iron record and a third for the wing record. If trials ended earlier, the error would grow
  /// by 1 %.
  double promising = 0.995;
  // One common k replaces k_ascending and k_descending if the errors stay below the following limit.
  /// Maximum error and held-out error with one k; costs a piezo stage 3 % of its error.
  double one_k = 1.05;

  // Limits for the selection of the curve shape.
  /// Order of the curves before k is known. With order 8, the error of a piezo stage is 3 % larger.
  int first_order = 5;
  /// Maximum score of a shape that counts as better, relative to the smallest score so far.
  double better_shape = 0.98;
  /// The search ends after so many shapes that are not better; even and odd orders differ, so one is not
  /// enough.
  int most_worse_shapes = 3;
  /// Maximum score of the selected shape, relative to the smallest score. Saves coefficients (order 7 instead
  /// of 8).
  double low_enough = 1.01;
  /// A score below this number of output spans is exact; a record without noise then gets order 4, not 7.
  double exact = 1e-6;
  /// A score above this number of output spans restarts the search with splines. Without a restart, the error
  /// of the iron record is 4.9 % instead of 1.4 %. With a restart in every case, the piezo stages take 2.5
  /// times as long without benefit.
  double poor = 0.01;
  /// Maximum score of a spline before k is searched again; halves the time for PZT.
  double hopeless_spline = 1.25;
  /// Maximum score of a spline relative to a polynomial, because a spline has more coefficients.
  double spline = 0.9;
  /// Index of the spline that is tried first; it has 12 pieces.
  std::size_t usual_spline = 7;
  /// Maximum score of a model with an input map. The map lowers the error of the wing record from 5.3 to 2.3
  /// %, and of iron from 2.6 to 1.4 %. The other records get no map.
  double input_map = 0.9;

  // Limits for the values of a trial.
  /// The simplex search is repeated if its last run lowered the error to this factor or less. A simplex
  /// search may end too early.
  double restart = 0.99;
  /// Maximum k, times the span of the thresholds or of a steep part.
  double widest_k_span = 200.0;
  /// Maximum distance of a threshold from the inputs, in input spans.
  double farthest_threshold = 3.0;
  /// A piece of a spline is steep if it is shorter than this number of input spans.
  double steep_part = 0.05;
};

inline constexpr SearchCriteria criteria;

}  // namespace hystcan::identification
