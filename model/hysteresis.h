// Recursive memory-based hysteresis (Bashash, Jalili, Evans, Dapino 2009), in a form that costs O(1) per
// sample.
//
// Input v in [v_lo, v_hi], output x; f_0^A <= f_0^D: ascending and descending reference curves, both
// increasing, meeting at the upper threshold.  U_0 = (v_hi, f_0^A(v_hi)) is the upper threshold point, L_0 =
// (v_lo, f_0^D(v_lo)) the lower convergence point.  With the turning points U_n, L_n still remembered (paper,
// eq. 4 and its mirror image), rising from L_n and falling from U_{n+1}:
//
//   f_{n+1}^A(v) = f_n^A(v) + (x_n^L - f_n^A(v_n^L)) g(v_n^U - v; v_n^U - v_n^L, k_A)
//   f_{n+1}^D(v) = f_n^D(v) + (x_{n+1}^U - f_n^D(v_{n+1}^U)) g(v - v_n^L; v_{n+1}^U - v_n^L, k_D)
//   g(s; S, k)   = (e^{ks} - 1) / (e^{kS} - 1)
//
// The sum over all surrounding loops collapses.  With the distance travelled d = |v - v_s| from the branch's
// start (v_s, x_s), and phi(d) = -expm1(-k d) / k  (phi(d) = d at k = 0), every branch is
//
//   f(v) = f_0(v) + c - S phi(d),      c = x_s - f_0(v_s),
//   S    = S_below e^{-k |v_s - v_below|} + [x_s - f_below(v_s)] / phi(|v_target - v_s|)
//
// where `below` is the branch of the same direction that was broken at the target (c = S = 0 on a reference
// curve). c and S are made once, at the reversal; wiping out is a pop.  docs/theory.md derives it.
//
// A branch is increasing where sigma S e^{-k d} < f_0'(v), sigma = +1 rising, -1 falling: checked at every
// reversal, at the start where sigma f_0'' + k f_0' >= 0 makes that enough, else wherever that changes its
// sign, and at the target, too.  One curve cannot keep this: falling branches that leave the virgin curve
// f_0^A near or below the output of L_0 (which they target) turn upwards, whatever k.  They are flagged where
// they are met, and gone after the first visit to a threshold.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "model/hysteresis_parameters.h"
#include "model/memory_model.h"

namespace hystcan::model {

/// The law of a branch: Branch::offset is c, in output units; Branch::coefficient is S, output units per
/// input unit, >= 0 rising and <= 0 falling in a regular loop.
class ExponentialConvergence {
 public:
  explicit ExponentialConvergence(HysteresisParameters parameters);

  const HysteresisParameters& parameters() const { return parameters_; }
  static constexpr std::string_view kind() { return "recursive-memory"; }
  std::uint64_t fingerprint() const;
  const Interval& input_range() const { return parameters_.input_range(); }
  Symmetry symmetry() const { return parameters_.symmetry; }

  Branch threshold_branch(Direction direction) const;
  Branch virgin_branch() const;
  Branch reversed(const HysteresisState& state) const;
  double value(const Branch& branch, Direction direction, double input) const;
  Jet jet(const Branch& branch, Direction direction, double input) const;
  double halley_tolerance() const { return halley_tolerance_; }

 private:
  /// phi and e^{-k d} of one direction.
  struct Convergence {
    double k = 0.0;                // 0 where phi(d) = d to rounding
    double reciprocal = 0.0;       // 1 / k
    bool lowest_at_start = true;   // sigma f_0'' + k f_0' >= 0: a branch is flattest where it starts
    bool steep = false;            // |k| times the input range > 1: 1 - e^{-k d} loses nothing that matters
    std::vector<double> flattest;  // inputs where that turns from negative to positive on the way
    double phi(double d) const;    // to 1e-16 / k, or to rounding where not steep
    double precise_phi(double d) const;  // to rounding: what a tiny loop is divided by
    double decay(double d) const;        // e^{-k d}
  };

  Convergence convergence(Direction direction) const;
  const Convergence& pace(Direction direction) const;
  double slope(const Branch& branch, Direction direction, double input) const;
  bool is_increasing(const Branch& branch, Direction direction, double target) const;
  double added_coefficient(const HysteresisState& state, double offset, double target) const;

  HysteresisParameters parameters_;
  Convergence ascending_, descending_;
  double slope_tolerance_ = 0.0;  // 1e-9 of the mean slope
  double halley_tolerance_ = 0.0;
};

/// The model: parameters, checked once. All memory is in the HysteresisState that is passed in.
class Hysteresis : public MemoryModel<ExponentialConvergence> {
 public:
  /// Throws std::invalid_argument, naming the interval, where a curve does not increase, the curves cross or
  /// do not meet at the upper threshold, or k is beyond the limit that keeps every branch increasing
  /// (model/validity.h).
  explicit Hysteresis(HysteresisParameters parameters);

  /// For the study of what lies beyond that limit (Fig. 6c and d of the paper): the curves are checked, the
  /// branches are not, and the inverse is not to be trusted where `increasing` is false.
  static Hysteresis beyond_limit(HysteresisParameters parameters);

  const HysteresisParameters& parameters() const { return law().parameters(); }

 private:
  explicit Hysteresis(ExponentialConvergence law) : MemoryModel(std::move(law)) {}
};

extern template class MemoryModel<ExponentialConvergence>;

}  // namespace hystcan::model
