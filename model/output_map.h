// The output of a butterfly. Strain does not tell the two directions of a magnetisation or polarisation m
// apart: it falls to a valley and rises from there. m itself is a recursive memory-based model of the input,
// with a coercivity that the fold x(v) = x(-v) does not have.
//
//   m = H[v]        increases with the input, with memory
//   x = g(m)        falls as far as the valley, rises beyond it
#pragma once

#include <vector>

#include "model/hysteresis_operator.h"
#include "model/reference_curve.h"

namespace hystcan::model {

class OutputMap {
 public:
  /// A Chebyshev series on `inner`, the range of m. Throws std::invalid_argument if it does not rise at its
  /// end, or if it has another valley, or a crest.
  OutputMap(const std::vector<double>& coefficients, Interval inner);

  double value(double m) const { return series_.value(m); }
  double slope(double m) const { return series_.slope(m); }
  /// m where x is least; the lower end of the range if x only rises.
  double valley() const { return valley_; }
  /// Outputs where m goes from `m.lo` to `m.hi`, without what lies before the valley.
  Interval beyond_valley(Interval m) const;

  /// m beyond the valley. value() of it is `output` to rounding. Saturated: the output lies below the valley
  /// or above the upper end, and m is there.
  Prediction inverse(double output) const;

  const std::vector<double>& coefficients() const { return series_.coefficients(); }
  const Interval& inner() const { return series_.domain(); }

 private:
  ReferenceCurve series_;
  double valley_ = 0.0;
};

}  // namespace hystcan::model
