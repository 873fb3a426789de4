#include "model/output_map.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "model/root.h"

namespace hystcan::model {
namespace {

constexpr int scanned = 1000;  // number of grid steps in the search for the valley

// Returns the magnetisation or polarisation m between `lo` and `hi` at which the slope of the output map is
// zero. The slope must be below zero at `lo` and above zero at `hi`.
double zero_of_slope(const ReferenceCurve& series, double lo, double hi) {
  for (int i = 0; i < 100; ++i) {
    const double middle = lo + (hi - lo) / 2.0;
    (series.slope(middle) < 0.0 ? lo : hi) = middle;
  }
  return lo + (hi - lo) / 2.0;
}

}  // namespace

OutputMap::OutputMap(const std::vector<double>& coefficients, Interval inner)
    : series_(Basis::chebyshev, coefficients, inner), valley_(inner.lo) {
  const double step = inner.span() / scanned;
  const double flat = 1e-9 * std::abs(series_.value(inner.hi) - series_.value(inner.lo)) / inner.span();
  bool rises = series_.slope(inner.lo) > -flat;
  for (int i = 1; i <= scanned; ++i) {
    const double m = i < scanned ? inner.lo + i * step : inner.hi;
    const double slope = series_.slope(m);
    if (rises && slope < -flat)
      refuse("output map falls at ", m, " after an increase, expected one valley and no crest");
    if (rises || slope < 0.0) continue;
    rises = true;
    valley_ = zero_of_slope(series_, m - step, m);
  }
  if (!rises)
    refuse("output map still falls at its upper end, ", inner.hi,
           ", expected an output map that rises at its upper end");
}

Interval OutputMap::beyond_valley(Interval m) const {
  return {value(std::max(m.lo, valley_)), value(std::max(m.hi, valley_))};
}

// Finds the root m of value(m) = `output`. The search starts at the m that a parabola would have: this
// parabola has its lowest point at the valley of the map and equals the map at the upper end.
Prediction OutputMap::inverse(double output) const {
  const double lo = valley_, hi = inner().hi;
  const double least = value(lo), most = value(hi);
  if (output <= least) return {lo, output < least};
  if (output >= most) return {hi, output > most};
  const double start = lo + (hi - lo) * std::sqrt((output - least) / (most - least));
  return {root_of_increasing([this](double m) { return series_.jet(m); }, {lo, hi, start}, output,
                             {.value = 2e-16 * std::max(std::abs(least), std::abs(most))})
              .input};
}

}  // namespace hystcan::model
