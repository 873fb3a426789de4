// Prandtl-Ishlinskii model: a weighted sum of play operators, with its analytic inverse. A baseline for
// comparison: its loops are symmetrical and congruent, and do not depend on their position in the range.
//
//   v in [v_lo, v_hi]      input
//   x                      output
//   0 < r_1 < ... < r_m    thresholds, input units
//   w_0, w_i               `gain` and weights, output units per input unit
//
//   x = x_0 + w_0 v + sum_{i=1..m} w_i y_i
//   y_i[n] = max(v[n] - r_i, min(v[n] + r_i, y_i[n-1]))                  play of threshold r_i
//   W_i = w_0 + ... + w_i > 0,  i = 0..m                                 so that x increases with v
//
// Inverse.  Plays are nested: with y_0 = v and r_0 = 0, y_i is the play of threshold r_i - r_{i-1} of
// y_{i-1}, so that |y_i - y_{i-1}| <= r_i - r_{i-1}.  While v rises, the plays therefore start to move in the
// order of i: play i at v = y_i + r_i, when all earlier plays already move at y_j = v - r_j.  From there on x
// has slope W_i.  (Falling: the same with -r.)  Expressed in x, play i starts to move at
//
//   x - x_0 = y'_i + r'_i,     y'_i = W_i y_i + sum_{j>i} w_j y_j,     r'_i = sum_{j<i} w_j (r_i - r_j)
//
// y'_i moves only when play i moves, at its edges. It is therefore itself a play of x - x_0, of threshold
// r'_i. The slope of v there becomes 1 / W_i: the inverse is again a Prandtl-Ishlinskii model,
//
//   v = w'_0 (x - x_0) + sum_i w'_i y'_i
//   w'_0 = 1 / w_0,     w'_i = 1 / W_i - 1 / W_{i-1} = -w_i / (W_i W_{i-1})
//
// inverse() starts at the present (v, x) and moves from one kink to the next. It avoids the products w'_i
// y'_i, which are large and cancel if a W_i is small. A small move passes few kinks.
//
// P. Krejci, K. Kuhnen, "Inverse control of systems with hysteresis and creep", IEE Proc. Control Theory
// Appl. 148(3), 2001.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/hysteresis_operator.h"
#include "model/reference_curve.h"

namespace hystcan::model {

/// The identified numbers of a model file.
struct PrandtlIshlinskiiParameters {
  std::string input_unit;
  std::string output_unit;
  Interval input_range;            ///< thresholds [v_lo, v_hi], input units
  double offset = 0.0;             ///< x_0: output at v = 0 with all plays at 0, output units
  double gain = 1.0;               ///< w_0: output units per input unit, greater than 0
  std::vector<double> thresholds;  ///< thresholds r_1, ..., r_m of the plays, input units; may be empty
  /// Weights w_1, ..., w_m of the plays, output units per input unit. A weight may be negative if every sum
  /// W_i = w_0 + ... + w_i is greater than 0.
  std::vector<double> weights;
};

/// The whole memory of the actuator. The output is always a function of the input and the plays.
struct PlayState {
  double input = 0.0;
  double output = 0.0;
  std::vector<double> plays;  ///< outputs of the plays: y_1, ..., y_m
};

/// The model holds its parameters, which are checked once. The memory is in the PlayState that the caller
/// passes; a state must have been made by this model.
///
/// forward() and inverse() do not change the memory; advance() does. None of the three allocates; each costs
/// O(m), with m the number of plays. Inputs outside input_range() and outputs outside reachable() are
/// replaced by the edge and flagged saturated. A non-finite argument is flagged not finite, and not
/// saturated: forward() and inverse() return NaN; advance() changes nothing and returns the present output.
class PrandtlIshlinskii {
 public:
  using State = PlayState;

  /// Throws std::invalid_argument, with the index, if a number is not finite, if the range is not lo < hi, if
  /// the thresholds do not increase from zero or do not match the weights, or if a sum W_i = w_0 + ... + w_i
  /// is not above its rounding error, 1e-12 (w_0 + |w_1| + ... + |w_i|).
  explicit PrandtlIshlinskii(PrandtlIshlinskiiParameters parameters);

  const PrandtlIshlinskiiParameters& parameters() const { return parameters_; }
  const Interval& input_range() const { return parameters_.input_range; }
  static constexpr std::string_view kind() { return "prandtl-ishlinskii"; }
  std::uint64_t fingerprint() const { return fingerprint_; }

  /// Returns the state with every play centred: y_i = input. Throws std::invalid_argument if `input` is
  /// outside the range.
  State virgin(double input) const;
  /// Restores a saved state. Throws std::invalid_argument if the state cannot belong to this model: a
  /// different number of plays, a number that is not finite, an input outside the range, or a play y_i that
  /// is too far from the play before it (the message contains the index i):
  ///   |y_i - y_{i-1}| > r_i - r_{i-1}      r_i: thresholds, r_0 = 0; y_0: input; tolerance: rounding
  /// This also refuses every play that is further than its threshold r_i from the input.
  State restore(double input, std::span<const double> plays) const;

  /// Returns the outputs that this state can reach within the input range.
  Interval reachable(const State& state) const;
  /// Returns the output that `input` would give.
  Prediction forward(const State& state, double input) const;
  /// Returns the input that would give `output`: forward(state, inverse(state, x).value).value = x.
  Prediction inverse(const State& state, double output) const;
  /// Applies `input`.
  Prediction advance(State& state, double input) const;
  Prediction advance(State& state, const Prediction& found) const { return advance(state, found.value); }

  /// Writes a [memory] table of kind "prandtl-ishlinskii": input, output, plays. Returns an empty text if the
  /// buffer `text` is too small.
  std::string_view save(const State& state, std::span<char> text) const;

 private:
  double clamped(double input) const;
  double output_at(const State& state, double input) const;
  double input_at(const State& state, double output) const;

  PrandtlIshlinskiiParameters parameters_;
  std::vector<double> slopes_;  // W_i = w_0 + ... + w_i: slope of the output while the plays 1 to i move
  std::uint64_t fingerprint_ = 0;
};

}  // namespace hystcan::model
