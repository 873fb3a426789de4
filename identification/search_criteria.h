// The numbers that decide in a search, each with the measurement behind it. The measurements use six records:
// iron (BH curve), a wing of shape memory wires, PZT, a magnet, and two piezo stages.
#pragma once

#include <cstddef>

namespace hystcan::identification {

/// Limits for the decisions of a search. The search tries a change, such as another shape of the curves. A
/// limit for an error or a score (ShapeScore) without a unit is a ratio: the value with the change, divided
/// by the value without it.
struct SearchCriteria {
  // An unknown is added if the error of the fit and the held-out error both fall to the following limits.

  /// Maximum error of the fit with the unknown, relative to the error without it. If this limit were 1, the
  /// held-out error of the record of iron (a BH curve) would be 15 % larger.
  double added = 0.97;
  /// Maximum held-out error with the unknown, relative to the held-out error without it; excludes unknowns
  /// that only follow noise.
  double added_held_out = 0.985;
  /// A simplex search tries each new unknown, with a limited number of trials. After two fifths of them, the
  /// unknown is dropped if the error is still above this limit, relative to the error without the unknown.
  /// This saves a fifth of the time for the record of iron and a third for the record of a shape memory wing.
  /// If unknowns were dropped even earlier, the error would grow by 1 %.
  double promising = 0.995;
  /// One common convergence rate k replaces k_ascending and k_descending if it changes the errors little.
  /// Maximum error and maximum held-out error with the common k, relative to the errors with two values. This
  /// limit makes the error of a piezo stage 3 % larger.
  double one_k = 1.05;

  // Limits for the selection of the curve shape.
  /// Order of the curves while the search has no value of the convergence rate k yet. With order 8, the error
  /// of a piezo stage is 3 % larger.
  int first_order = 5;
  /// Maximum score of a shape that counts as better, relative to the smallest score so far.
  double better_shape = 0.98;
  /// The search for a shape ends after this number of consecutive shapes that are not better than the best
  /// shape before them. One such shape is not enough, because the errors of curves of even and odd order
  /// differ.
  int most_worse_shapes = 3;
  /// Maximum score (ShapeScore) of the selected shape, relative to the smallest score of all shapes. The
  /// first shape below this limit is selected. It has fewer coefficients than the best shape: for example,
  /// order 7 instead of 8.
  double low_enough = 1.01;
  /// A shape whose score (ShapeScore) is below this share of the output span counts as exact. A record
  /// without noise then gets curves of order 4; otherwise it would get order 7.
  double exact = 1e-6;
  /// If the score (ShapeScore) of the best polynomial is above this share of the output span, the search
  /// starts again with splines. Without this restart, the error of the record of iron is 4.9 % instead of
  /// 1.4 %. With a restart in every case, the piezo stages take 2.5 times as long without benefit.
  double poor = 0.01;
  /// Maximum score of the best spline before its convergence rates k and the other unknowns are refined,
  /// relative to the score of the polynomial. Above this limit, the spline is dropped. This halves the time
  /// for the record of a PZT actuator.
  double hopeless_spline = 1.25;
  /// Maximum score of a spline that replaces a polynomial, relative to the score of the polynomial. The limit
  /// is below 1, because a spline has more coefficients.
  double spline = 0.9;
  /// After a restart with splines, the first spline has 12 pieces. This number is its index in the list of
  /// the splines that the search tries, from 2 to 22 pieces.
  std::size_t usual_spline = 7;
  /// Maximum score of a model with an input map (CurveShape::input_map), relative to the score without it.
  /// The map lowers the error of the record of a shape memory wing from 5.3 to 2.3 %, and of iron from 2.6 to
  /// 1.4 %. The other records get no map.
  double input_map = 0.9;

  // Limits for the simplex search, and for the values of a trial.
  /// A simplex search may end too early. It is repeated if the error after its last run is at most this share
  /// of the error before this run.
  double restart = 0.99;
  /// Maximum of the convergence rate k times the distance of the thresholds, without a unit. A spline with a
  /// short piece may have a larger k (steep_part).
  double widest_k_span = 200.0;
  /// Maximum distance of a threshold of the model from the range of the observed inputs, divided by the
  /// length of this range.
  double farthest_threshold = 3.0;
  /// A spline has short pieces where the output is steep, and loops inside such a piece need a large
  /// convergence rate k. If the shortest piece is shorter than this share of the input span, the maximum k is
  /// larger by a factor: this share of the input span, divided by the length of the piece.
  double steep_part = 0.05;
};

inline constexpr SearchCriteria criteria;

}  // namespace hystcan::identification
