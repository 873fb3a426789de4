// The output of a butterfly. Strain is the same for both directions of a magnetisation or polarisation m: as
// m increases, the strain falls to a valley and rises from there. m itself is a recursive memory-based model
// of the input, with a coercivity. A model with even symmetry, x(v) = x(-v), cannot represent a coercivity.
//
//   m = H[v]        increases with the input, with memory
//   x = g(m)        falls to the valley, then rises
#pragma once

#include <vector>

#include "model/hysteresis_operator.h"
#include "model/reference_curve.h"

namespace hystcan::model {

class OutputMap {
 public:
  /// Constructs g as a Chebyshev series on `inner`, the range of m. Throws std::invalid_argument if g does
  /// not rise at its upper end, or if it has a second valley or a crest.
  OutputMap(const std::vector<double>& coefficients, Interval inner);

  double value(double m) const { return series_.value(m); }
  double slope(double m) const { return series_.slope(m); }
  /// Returns the m with the lowest output; the lower end of the range of m if the output only rises.
  double valley() const { return valley_; }
  /// Returns the outputs for m from `m.lo` to `m.hi`, without the part before the valley.
  Interval beyond_valley(Interval m) const;

  /// Returns the m beyond the valley with value(m) = `output`, to rounding. Saturated: the output is below
  /// the valley or above the upper end, and the returned m is the valley or the upper end.
  Prediction inverse(double output) const;

  const std::vector<double>& coefficients() const { return series_.coefficients(); }
  const Interval& inner() const { return series_.domain(); }

 private:
  ReferenceCurve series_;
  double valley_ = 0.0;
};

}  // namespace hystcan::model
