// Recursive memory-based hysteresis (Bashash, Jalili, Evans, Dapino 2009), in a form that costs O(1) per
// sample.
//
// Input v in [v_lo, v_hi], output x; f_0^A <= f_0^D: ascending and descending reference curves, both
// increasing, meeting at the upper threshold.  U_0 = (v_hi, f_0^A(v_hi)) is the upper threshold point, L_0 =
// (v_lo, f_0^D(v_lo)) the lower convergence point.  With the turning points U_n, L_n still remembered (paper,
// eq. 4 and its mirror image):
//
//   f_{n+1}^A(v) = f_n^A(v) + (x_n^L - f_n^A(v_n^L)) g(v_n^U - v; v_n^U - v_n^L, k_A)                rising
//   from L_n f_{n+1}^D(v) = f_n^D(v) + (x_{n+1}^U - f_n^D(v_{n+1}^U)) g(v - v_n^L; v_{n+1}^U - v_n^L, k_D)
//   falling from U_{n+1} g(s; S, k)   = (e^{ks} - 1) / (e^{kS} - 1)
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
// Branches b_0, b_1, ... alternate in direction.  b_0 starts at a threshold point and targets the opposite
// one; b_j targets the start of b_{j-1} and has b_{j-2} below.  Reaching the target of b_m pops b_m and
// b_{m-1}: the path continues on b_{m-2}, the curve that was broken there.  At a threshold a single branch
// remains, which starts there.
//
// A branch is increasing where sigma S e^{-k d} < f_0'(v), sigma = +1 rising, -1 falling.  One curve cannot
// keep this: falling branches that leave the virgin curve f_0^A near or below the output of L_0 (which they
// target) turn upwards, whatever k.  They are flagged where they are met, and gone after the first visit to a
// threshold.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "model/reference_curve.h"

namespace hystcan::model {

enum class Symmetry { none, even };  ///< even: x(v) = x(-v), the butterfly of magnetostriction

enum class Direction : int { ascending = 1, descending = -1 };

/// What is identified and kept in a model file. k in 1/input unit, of either sign.
struct HysteresisParameters {
  std::string input_unit;
  std::string output_unit;
  ReferenceCurve ascending;   ///< f_0^A
  ReferenceCurve descending;  ///< f_0^D
  double k_ascending = 0.0;
  double k_descending = 0.0;
  Symmetry symmetry = Symmetry::none;
};

/// One remembered branch: the turning point where it started, and its two coefficients.
struct Branch {
  double start_input = 0.0;
  double start_output = 0.0;
  double offset = 0.0;  ///< c, output units
  double coefficient =
      0.0;  ///< S, output units per input unit; signed: >= 0 rising, <= 0 falling in a regular loop
  bool increasing =
      true;  ///< sigma S e^{-k d} < f_0' at its start, and at its target where that may be the lower end
};

/// A stack that never allocates once made, nor do its copies lose capacity.
class BranchStack {
 public:
  explicit BranchStack(std::size_t capacity = 0) : slots_(capacity) {}

  std::size_t size() const { return size_; }
  std::size_t capacity() const { return slots_.size(); }
  bool full() const { return size_ == slots_.size(); }
  const Branch& operator[](std::size_t i) const { return slots_[i]; }
  const Branch& back() const { return slots_[size_ - 1]; }
  const Branch* begin() const { return slots_.data(); }
  const Branch* end() const { return slots_.data() + size_; }
  void push(const Branch& branch) { slots_[size_++] = branch; }  ///< not where full()
  void keep(std::size_t count) { size_ = count; }                ///< pops until `count` are left

 private:
  std::vector<Branch> slots_;
  std::size_t size_ = 0;
};

/// All that the actuator remembers. Branches alternate in direction; the last is the one being travelled.
/// The first starts at a threshold point. The virgin state is one ascending branch with c = S = 0, which is
/// f_0^A itself: its start L_0 is not on it, but is what every falling branch targets.
///
/// Memory full: a reversal makes no new branch, the innermost branch is travelled backwards instead, and left
/// through its start into the branch that was broken there. The path stays continuous and increasing; what is
/// lost is the loop that would have opened inside the innermost one. `merged` counts the steps taken so.
struct HysteresisState {
  BranchStack branches;                     ///< capacity fixed at construction, never exceeded
  Direction bottom = Direction::ascending;  ///< direction of branches[0]
  double input = 0.0;                       ///< |v| where symmetry is even
  double output = 0.0;
  std::size_t merged = 0;

  std::size_t depth() const { return branches.size(); }
  Direction direction() const { return direction(depth() - 1); }
  Direction direction(std::size_t index) const {
    return (index % 2 == 0) == (bottom == Direction::ascending) ? Direction::ascending
                                                                : Direction::descending;
  }
};

/// Being limited is not an error but a reason, told beside the value.
struct Prediction {
  double value = 0.0;      ///< output of forward(), input of inverse()
  bool saturated = false;  ///< the request lay outside the thresholds, and was taken at the threshold
  bool increasing = true;  ///< false: the branch in use is not increasing, its inverse is not to be trusted
};

/// The model: parameters, checked once. All memory is in the HysteresisState that is passed in.
///
/// forward() and inverse() only look; advance() moves the memory. None of them allocates.
/// A non-finite argument to forward() or inverse() gives a NaN value, flagged saturated; to advance(), no
/// change: it returns the present output, flagged saturated.
class Hysteresis {
 public:
  /// Throws std::invalid_argument, naming the interval, where a curve does not increase, the curves cross or
  /// do not meet at the upper threshold, or k is beyond the limit that keeps every branch increasing
  /// (model/validity.h).
  explicit Hysteresis(HysteresisParameters parameters);

  const HysteresisParameters& parameters() const { return parameters_; }
  const Interval& input_range() const { return parameters_.ascending.domain(); }
  /// [L_0, U_0]: outputs that can be reached whatever the memory.
  Interval output_range() const { return {lower_.start_output, upper_.start_output}; }

  /// On the initial ascending curve f_0^A at `input`, nothing remembered. `capacity`: branches, at least 4.
  /// Throws std::invalid_argument where `input` lies outside the thresholds or the capacity is too small.
  HysteresisState virgin(double input, std::size_t capacity = 256) const;
  /// At a threshold point: everything before is wiped out.
  HysteresisState at_lower_threshold(std::size_t capacity = 256) const;
  HysteresisState at_upper_threshold(std::size_t capacity = 256) const;

  /// Output that `input` would give.
  Prediction forward(const HysteresisState& state, double input) const;
  /// Input (>= 0 where symmetry is even) that would give `output`: forward(state, inverse(state,
  /// x).value).value = x.
  Prediction inverse(const HysteresisState& state, double output) const;
  /// Applies `input`: turning points are remembered, closed loops wiped out.
  Prediction advance(HysteresisState& state, double input) const;

 private:
  /// phi and e^{-k d} of one direction.
  struct Convergence {
    double k = 0.0;               // 0 where phi(d) = d to rounding
    double reciprocal = 0.0;      // 1 / k
    bool lowest_at_start = true;  // +-ref'' + k ref' >= 0: a branch is flattest where it starts
    bool steep = false;           // |k| times the input range > 1: 1 - e^{-k d} loses nothing that matters
    double phi(double d) const;
    double decay(double d) const;  // e^{-k d}
  };
  struct Segment;

  HysteresisState at_threshold(Direction from, std::size_t capacity) const;
  Convergence convergence(Direction direction) const;
  const ReferenceCurve& curve(Direction direction) const;
  const Convergence& pace(Direction direction) const;
  double value(const Branch& branch, Direction direction, double input) const;
  double slope(const Branch& branch, Direction direction, double input) const;
  bool is_increasing(const Branch& branch, Direction direction, double target) const;
  Branch threshold_branch(Direction direction) const;
  Branch reversed(const HysteresisState& state) const;
  double added_coefficient(const HysteresisState& state, double offset, double target) const;
  template <double Branch::*axis>
  Segment locate(const HysteresisState& state, double from, double to) const;
  bool stays_on_branch(const HysteresisState& state, double input) const;
  Prediction on_branch(const HysteresisState& state, double input) const;
  double follow(const Segment& segment, double input) const;
  double solve(const Segment& segment, double output) const;

  HysteresisParameters parameters_;
  Convergence ascending_, descending_;
  double slope_tolerance_ = 0.0;   // 1e-9 of the mean slope
  double newton_tolerance_ = 0.0;  // a Newton step below this leaves an error of rounding
  Branch lower_, upper_;           // the branches that start at L_0 and at U_0
};

}  // namespace hystcan::model
