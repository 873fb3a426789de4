// The linear mapping model (Bashash, Jalili 2006, 2008), the predecessor of the recursive model.  The memory
// is the same, but every branch is an affine image of its reference curve that joins its start to its target.
//
//   f(v) = x_s + b [f_0(v) - f_0(v_s)],      b = (x_target - x_s) / (f_0(v_target) - f_0(v_s))
//
// The branch starts at (v_s, x_s) and its target is (v_target, x_target). f_0 is the reference curve of the
// branch's direction.  The branch passes through both ends, but between them it can leave the surrounding
// loop: the inner branches of a strongly bent curve cross the outer ones. The recursive model avoids this.
// The linear mapping model is a baseline for comparison.
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

#include "model/hysteresis_parameters.h"
#include "model/memory_model.h"

namespace hystcan::model {

/// The law of a branch: its output as a function of the input,
///
///   f(v) = x_s + b [f_0(v) - f_0(v_s)]      (v_s, x_s): start of the branch; f_0: reference curve
///
/// Branch::coefficient is the factor b, and Branch::offset is x_s - b f_0(v_s).
class AffineMap {
 public:
  using Parameters = HysteresisParameters;
  /// Uses the reference curves, the units and the symmetry of the parameters; ignores the convergence rates
  /// k. Throws std::invalid_argument if the curves are not valid (model/validity.h).
  explicit AffineMap(HysteresisParameters parameters);

  const HysteresisParameters& parameters() const { return parameters_; }
  static constexpr std::string_view kind() { return "linear-mapping"; }
  std::uint64_t fingerprint() const;
  const Interval& input_range() const { return parameters_.input_range(); }
  Symmetry symmetry() const { return parameters_.symmetry; }

  Branch threshold_branch(Direction direction) const;
  Branch virgin_branch() const;
  Branch reversed(const HysteresisState& state) const;
  double value(const Branch& branch, Direction direction, double input) const;
  Jet jet(const Branch& branch, Direction direction, double input) const;
  double third_derivative_bound(const Branch& branch, Direction direction) const {
    return std::abs(branch.coefficient) *
           (direction == Direction::ascending ? ascending_third_ : descending_third_);
  }

 private:
  Branch joined(Point start, Point target, Direction direction) const;

  HysteresisParameters parameters_;
  // Upper bound of the third derivative of each curve.
  double ascending_third_ = 0.0, descending_third_ = 0.0;
};

using LinearMapping = MemoryModel<AffineMap>;
extern template class MemoryModel<AffineMap>;

}  // namespace hystcan::model
