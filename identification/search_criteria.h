// The numbers by which a search decides, and what each was chosen for. Measured: iron (BH curve), a wing of
// shape memory wires, PZT, a magnet, two piezo stages.
#pragma once

#include <cstddef>

namespace hystcan::identification {

/// The unit of an error or a score (ShapeScore) is that without the change, if no other one is given.
struct SearchCriteria {
  // An unknown is added if the error falls.
  double added = 0.97;            ///< largest error; with 1 iron's held-out error is 15 % larger
  double added_held_out = 0.985;  ///< largest held-out error: against unknowns that only follow noise
  double promising = 0.995;       ///< largest error after two fifths of the evaluations: spares iron a fifth
                                  ///< of the time, the wing a third; earlier ends cost 1 % of the error
  // One k takes the place of two.
  double one_k = 1.05;  ///< largest error, also held-out; costs a piezo stage 3 %

  // The shape of the curves.
  int first_order = 5;            ///< of the curves before k is known; a piezo stage misses 3 % more with 8
  double better_shape = 0.98;     ///< largest score, in least scores before: a shape that is better
  int most_worse_shapes = 3;      ///< in succession: even and odd orders differ
  double low_enough = 1.01;       ///< largest score, in least scores: spares coefficients (order 7 for 8)
  double exact = 1e-6;            ///< in output spans; a record without noise takes order 4 instead of 7
  double poor = 0.01;             ///< in output spans: begin again with splines. Never: iron misses 4.9
                                  ///< instead of 1.4 %; always: piezo stages take 2.5 times as long, in vain
  double hopeless_spline = 1.25;  ///< largest score before k is searched; halves the time of PZT
  double spline = 0.9;            ///< largest score: a spline has more coefficients
  std::size_t usual_spline = 7;   ///< index of the first spline among those that are tried: 12 pieces
  double input_map = 0.9;         ///< largest score; wing 5.3 -> 2.3 %, iron 2.6 -> 1.4 %, others none

  // The trials.
  double restart = 0.99;            ///< largest error that is worth another simplex: one can end early
  double widest_k_span = 200.0;     ///< k times the span of the thresholds, or of a steep part
  double farthest_threshold = 3.0;  ///< beyond the inputs, in their spans
  double steep_part = 0.05;         ///< in spans of the inputs: a shorter piece of a spline is steep
};

inline constexpr SearchCriteria criteria;

}  // namespace hystcan::identification
