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
  /// Constructs the map g(m) from the coefficients of its Chebyshev series. `inner`: range of the
  /// magnetisation or polarisation m. Throws std::invalid_argument if g does not rise at its upper end, or if
  /// g falls after it has risen.
  OutputMap(const std::vector<double>& coefficients, Interval inner);

  double value(double m) const { return series_.value(m); }
  double slope(double m) const { return series_.slope(m); }
  /// Returns the valley: the magnetisation or polarisation m with the lowest output. If the output only
  /// rises, this is the lower end of the range of m.
  double valley() const { return valley_; }
  /// Returns the outputs for the interval of m (magnetisation or polarisation), without the part of the
  /// interval before the valley, where the output falls.
  Interval beyond_valley(Interval m) const;

  /// Returns the m (magnetisation or polarisation) with value(m) = `output`, to rounding. Of the two
  /// solutions, returns the one beyond the valley, where the output rises. The result is saturated if the
  /// output is below the valley or above the upper end; the returned m is then the valley or the upper end.
  Prediction inverse(double output) const;

  const std::vector<double>& coefficients() const { return series_.coefficients(); }
  const Interval& inner() const { return series_.domain(); }

 private:
  ReferenceCurve series_;
  double valley_ = 0.0;
};

}  // namespace hystcan::model
