// The numbers that decide in a search, each with the measurement behind it. The measurements use six records:
// iron (BH curve), a wing of shape memory wires, PZT, a magnet, and two piezo stages.
#pragma once

#include <cstddef>

namespace hystcan::identification {

/// Limits for the decisions of a search. If no unit is given, an error or a score (ShapeScore) is a share of
/// its value without the change that is tried.
struct SearchCriteria {
  // An unknown is added if both errors fall to the following limits.
  /// Maximum error with the unknown, relative to the error without it. If this limit were 1, the held-out
  /// error of the iron record would be 15 % larger.
  double added = 0.97;
  /// Maximum held-out error with the unknown, relative to the held-out error without it; excludes unknowns
  /// that only follow noise.
  double added_held_out = 0.985;
  /// Maximum error with a new unknown after two fifths of the evaluations, relative to the error without it;
  /// above this limit, the unknown is dropped early. Saves a fifth of the time for the iron record and a
  /// third for the wing record. If unknowns were dropped even earlier, the error would grow by 1 %.
  double promising = 0.995;
  // One common k replaces k_ascending and k_descending if the errors stay below the following limit.
  /// Maximum error and held-out error with one k, relative to the errors with two. This limit makes the error
  /// of a piezo stage 3 % larger.
  double one_k = 1.05;

  // Limits for the selection of the curve shape.
  /// Order of the curves before k is known. With order 8, the error of a piezo stage is 3 % larger.
  int first_order = 5;
  /// Maximum score of a shape that counts as better, relative to the smallest score so far.
  double better_shape = 0.98;
  /// The search ends after this number of consecutive shapes that are not better. One such shape is not
  /// enough, because the errors of curves of even and odd order differ.
  int most_worse_shapes = 3;
  /// Maximum score of the selected shape, relative to the smallest score. Saves coefficients (order 7 instead
  /// of 8).
  double low_enough = 1.01;
  /// A score below this share of the output span counts as zero. A record without noise then gets curves of
  /// order 4, not 7.
  double exact = 1e-6;
  /// A score above this share of the output span restarts the search with splines. Without a restart, the
  /// error of the iron record is 4.9 % instead of 1.4 %. With a restart in every case, the piezo stages take
  /// 2.5 times as long without benefit.
  double poor = 0.01;
  /// Maximum score of a spline before k is searched again, relative to the score of the polynomial. Above
  /// this limit, the spline is dropped. This halves the time for PZT.
  double hopeless_spline = 1.25;
  /// Maximum score of a spline that replaces a polynomial, relative to the score of the polynomial. The limit
  /// is below 1, because a spline has more coefficients.
  double spline = 0.9;
  /// Index of the spline that is tried first; it has 12 pieces.
  std::size_t usual_spline = 7;
  /// Maximum score of a model with an input map, relative to the model without it. The map lowers the error
  /// of the wing record from 5.3 to 2.3 %, and of iron from 2.6 to 1.4 %. The other records get no map.
  double input_map = 0.9;

  // Limits for the simplex search, and for the values of a trial.
  /// A simplex search may end too early. It is repeated if the error after its last run is at most this share
  /// of the error before this run.
  double restart = 0.99;
  /// Maximum of k times the span between the thresholds, without a unit. A spline with a short piece may have
  /// a larger k (steep_part).
  double widest_k_span = 200.0;
  /// Maximum distance of a threshold from the inputs, in input spans.
  double farthest_threshold = 3.0;
  /// A spline has short pieces where the output is steep, and loops inside such a piece need a large k. If
  /// the shortest piece is shorter than this share of the input span, the maximum k is multiplied by the
  /// quotient: this share of the span, divided by the length of the piece.
  double steep_part = 0.05;
};

inline constexpr SearchCriteria criteria;

}  // namespace hystcan::identification
