// Recursive memory-based hysteresis (Bashash, Jalili, Evans, Dapino 2009), in a form that costs O(1) per
// sample.
//
//   v in [v_lo, v_hi]           input
//   x                           output
//   f_0^A <= f_0^D              ascending and descending reference curves; both increase and meet at v_hi
//   U_0 = (v_hi, f_0^A(v_hi))   upper threshold point
//   L_0 = (v_lo, f_0^D(v_lo))   lower convergence point
//   U_n, L_n                    turning points that are still remembered
//
// The branches that rise from L_n = (v_n^L, x_n^L) and fall from U_{n+1} = (v_{n+1}^U, x_{n+1}^U), with the
// convergence rates k_A and k_D, are (paper, eq. 4 and its mirror image)
//
//   f_{n+1}^A(v) = f_n^A(v) + (x_n^L - f_n^A(v_n^L)) g(v_n^U - v; v_n^U - v_n^L, k_A)
//   f_{n+1}^D(v) = f_n^D(v) + (x_{n+1}^U - f_n^D(v_{n+1}^U)) g(v - v_n^L; v_{n+1}^U - v_n^L, k_D)
//   g(s; l, k)   = (e^{ks} - 1) / (e^{kl} - 1)
//
// The sum over all surrounding loops collapses into one term.  Every branch starts at (v_s, x_s) and is
//
//   f(v)   = f_0(v) + c - S phi(d),      c = x_s - f_0(v_s),      d = |v - v_s|
//   S      = S_below e^{-k |v_s - v_below|} + [x_s - f_below(v_s)] / phi(|v_target - v_s|)
//   phi(d) = -expm1(-k d) / k            phi(d) = d at k = 0
//
// `below` is the branch of the same direction that ended at the target (c = S = 0 on a reference curve). c
// and S are computed once, at the reversal.  Wiping out pops branches. docs/theory/model.md contains the
// derivation.
//
// With an input map h, all distances are d = |h(v) - h(v_s)|: convergence is fast where h is steep.
//
// A branch increases if, with sigma = +1 rising and -1 falling,
//
//   sigma S e^{-k d} < f_0'(v) / h'(v)
//
// The model checks this at the start of the branch at every reversal. That is sufficient if the term sigma
// (f_0' / h')' + k f_0' is never negative. Otherwise the model also checks the branch at the inputs where
// this term changes from negative to positive, and at the target. Some branches cannot increase: a falling
// branch that leaves the virgin curve f_0^A near or below the output of its target L_0 turns upwards for
// every k. The model flags such a branch when it uses the branch. This cannot happen after the first visit to
// a threshold.
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

#include "model/hysteresis_parameters.h"
#include "model/memory_model.h"

namespace hystcan::model {

/// The law of a branch: its output as a function of the input,
///
///   f(v) = f_0(v) + c - S phi(d)        (f_0, phi, d: top of this file)
///
/// Branch::offset is c, in output units. Branch::coefficient is S, in output units per unit of the input map
/// h. If a loop opens in the usual direction, S >= 0 on a rising branch, and S <= 0 on a falling branch.
class ExponentialConvergence {
 public:
  using Parameters = HysteresisParameters;
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
  double third_derivative_bound(const Branch& branch, Direction direction) const {
    const Convergence& convergence = direction == Direction::ascending ? ascending_ : descending_;
    return convergence.curve_third + std::abs(branch.coefficient) * convergence.fading_third;
  }

 private:
  /// The functions phi(d) and e^{-k d} for the k of one direction (formulas at the top of this file).
  struct Convergence {
    double k = 0.0;               // convergence rate; 0 if it is so small that phi(d) equals d to rounding
    double reciprocal = 0.0;      // 1 / k, with the convergence rate k; 0 if k is 0
    bool lowest_at_start = true;  // true: a branch that increases at its start increases everywhere
    bool steep = false;           // true: |k| times the input range > 1, so that 1 - e^{-k d} is accurate
    // Upper bound of |third derivative| of the curve f_0; infinity with an input map.
    double curve_third = 0.0;
    double fading_third = 0.0;  // upper bound of |third derivative| of phi(d)
    // Inputs at which a branch may decrease although it increases at both ends. At these inputs, the
    // following term changes from negative to positive, with the reference curve f_0, the input map h, and
    // sigma = 1 for a rising and -1 for a falling branch:
    //   sigma (f_0' / h')' + k f_0'
    std::vector<double> flattest;
    double phi(double d) const;  // returns phi(d); absolute error 1e-16 / k if `steep`, else only rounding
    // Returns phi(d) with an error of rounding only, also for a tiny d. The coefficient of a branch in a tiny
    // loop is divided by phi of the loop's width, so it needs this accuracy.
    double precise_phi(double d) const;
    double decay(double d) const;  // returns e^{-k d}
  };

  Convergence convergence(Direction direction) const;
  double between(double a, double b) const;  // returns d, the distance between two inputs
  const Convergence& pace(Direction direction) const;
  double slope(const Branch& branch, Direction direction, double input) const;
  bool is_increasing(const Branch& branch, Direction direction, double target) const;
  double added_coefficient(const HysteresisState& state, double offset, double target) const;

  HysteresisParameters parameters_;
  Convergence ascending_, descending_;
  // 1e-9 of the mean slope: a branch may fall by this slope, because of rounding.
  double slope_tolerance_ = 0.0;
};

extern template class MemoryModel<ExponentialConvergence>;

/// The model holds its parameters, which are checked once. The memory is in the HysteresisState that the
/// caller passes.
///
/// The functions are the functions of MemoryModel, with every output mapped by the output map of a butterfly.
/// The output of a butterfly falls to a valley and then rises (model/output_map.h). inverse() uses only the
/// part beyond the valley, where the map increases. An output that only the part before the valley has counts
/// as out of reach.
class Hysteresis : private MemoryModel<ExponentialConvergence> {
  using Levels = MemoryModel<ExponentialConvergence>;

 public:
  using Levels::default_capacity;
  using Levels::fingerprint;
  using Levels::input_range;
  using Levels::kind;
  using Levels::parameters;
  using Levels::save;
  using Levels::saved_size;
  using Levels::State;
  using Levels::symmetry;

  /// Throws std::invalid_argument if a curve does not increase, if the curves cross or do not meet at the
  /// upper threshold, or if k exceeds the limit that keeps every branch increasing (model/validity.h). The
  /// message contains the defect and its place.
  explicit Hysteresis(HysteresisParameters parameters);

  /// For studies with a k beyond the limit (Fig. 6c and d of the paper): checks the curves, but not the
  /// branches. The inverse is not reliable if `increasing` is false.
  static Hysteresis beyond_limit(HysteresisParameters parameters);

  Interval output_range() const { return shown(Levels::output_range()); }
  Interval reachable(const State& state) const { return shown(Levels::reachable(state)); }
  Interval reachable(const State& state, Interval inputs) const {
    return shown(Levels::reachable(state, inputs));
  }
  State virgin(double input, std::size_t capacity = default_capacity) const {
    return shown(Levels::virgin(input, capacity));
  }
  State at_lower_threshold(std::size_t capacity = default_capacity) const {
    return shown(Levels::at_lower_threshold(capacity));
  }
  State at_upper_threshold(std::size_t capacity = default_capacity) const {
    return shown(Levels::at_upper_threshold(capacity));
  }
  State remembering(const TurningPoints& points, std::size_t capacity = default_capacity) const {
    return shown(Levels::remembering(points, capacity));
  }
  Prediction forward(const State& state, double input) const;
  FoundInput inverse(const State& state, double output) const;
  Prediction advance(State& state, double input) const;
  Prediction advance(State& state, const FoundInput& found) const;

 private:
  explicit Hysteresis(ExponentialConvergence law) : MemoryModel(std::move(law)) {}

  Interval shown(Interval levels) const { return parameters().outputs(levels.lo, levels.hi); }
  State shown(State state) const {
    state.output = parameters().output(state.level);
    return state;
  }
};

}  // namespace hystcan::model
