// Reference curves: the increasing functions f_0^A and f_0^D that shape every hysteresis loop.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "model/cubic_spline.h"

namespace hystcan::model {

/// Input range [lo, hi] of a curve, lo < hi, in input units.
struct Interval {
  double lo = 0.0;
  double hi = 1.0;

  double span() const { return hi - lo; }
  bool contains(double v) const { return lo <= v && v <= hi; }
};

enum class Basis { power, chebyshev, spline };
constexpr auto words(Basis) { return std::to_array<std::string_view>({"power", "chebyshev", "spline"}); }

/// A Chebyshev series on s in [-1, 1]. It is evaluated as a polynomial in s, four terms at a time, if that
/// loses less than four bits of accuracy: if sum |coefficients of s^j| <= 16 sum |coefficients of T_j|.
/// Otherwise Clenshaw's recurrence is used; it is slower, but as well conditioned at order 20 as at order 1.
class ChebyshevSeries {
 public:
  explicit ChebyshevSeries(std::vector<double> coefficients);

  double operator()(double s) const { return powers_.empty() ? clenshaw(s) : in_powers(s); }
  const std::vector<double>& coefficients() const { return chebyshev_; }
  /// Returns the coefficients of s^0, s^1, ..., with zeros up to a multiple of four; empty if Clenshaw's
  /// recurrence is used.
  const std::vector<double>& powers() const { return powers_; }
  ChebyshevSeries derivative(double ds_dv) const;

 private:
  double in_powers(double s) const {
    const double q = s * s, qq = q * q;
    const double* a = powers_.data() + powers_.size() - 4;
    double sum = (a[0] + a[1] * s) + q * (a[2] + a[3] * s);
    while (a != powers_.data()) {
      a -= 4;
      sum = ((a[0] + a[1] * s) + q * (a[2] + a[3] * s)) + qq * sum;
    }
    return sum;
  }
  double clenshaw(double s) const;

  std::vector<double> chebyshev_;
  std::vector<double> powers_;
};

/// A polynomial or a cubic spline on an interval. A polynomial is always stored in the Chebyshev basis of the
/// interval:
///
///   f(v) = sum c_j T_j(s),    s = (2 v - lo - hi) / (hi - lo)
///
/// T_j are the Chebyshev polynomials of the first kind.
class ReferenceCurve {
 public:
  /// A placeholder: zero on [0, 1]. No Hysteresis accepts it.
  ReferenceCurve() : ReferenceCurve(Basis::power, {0.0}, {0.0, 1.0}) {}

  /// Constructs a polynomial. `coefficients` multiply v^0, v^1, ... (power) or T_0, T_1, ... (chebyshev).
  /// Throws std::invalid_argument if they are empty, more than 33 or not finite, or if not lo < hi.
  ReferenceCurve(Basis basis, const std::vector<double>& coefficients, Interval domain);

  /// Throws std::invalid_argument if a coefficient is not finite, or if the knots are outside the interval.
  ReferenceCurve(CubicSpline spline, Interval domain);

  double value(double v) const { return spline_ ? spline_->value(v) : value_(ds_dv_ * (v - centre_)); }
  double slope(double v) const {  ///< slope df/dv, output units per input unit
    return spline_ ? spline_->slope(v) : slope_(ds_dv_ * (v - centre_));
  }
  double curvature(double v) const {  ///< second derivative d2f/dv2
    return spline_ ? spline_->curvature(v) : curvature_(ds_dv_ * (v - centre_));
  }
  /// Returns an upper bound of |d3f/dv3| on the interval; infinity if the interval extends beyond the knots
  /// of a spline.
  double third_derivative_bound() const;
  Jet jet(double v) const {
    if (spline_) return spline_->jet(v);
    if (blocks_.empty()) return {value(v), slope(v), curvature(v)};
    const double s = ds_dv_ * (v - centre_), q = s * s, qq = q * q;
    const auto block = [&](const double* a) { return (a[0] + a[1] * s) + q * (a[2] + a[3] * s); };
    Jet sum;
    for (const double* a = blocks_.data() + blocks_.size(); a != blocks_.data();) {
      a -= 12;
      sum.value = block(a) + qq * sum.value;
      sum.slope = block(a + 4) + qq * sum.slope;
      sum.curvature = block(a + 8) + qq * sum.curvature;
    }
    return sum;
  }

  const Interval& domain() const { return domain_; }
  /// Returns Basis::chebyshev or Basis::spline.
  Basis basis() const { return spline_ ? Basis::spline : Basis::chebyshev; }
  const std::vector<double>& coefficients() const {
    return spline_ ? spline_->coefficients() : value_.coefficients();
  }
  const std::vector<double>& knots() const;  ///< knots of a spline; empty for a polynomial
  /// Returns a curve with these coefficients and the same basis, knots and interval.
  ReferenceCurve with(const std::vector<double>& coefficients) const;

 private:
  Interval domain_;
  double centre_;  // middle of the interval: a polynomial uses the scaled input s = ds_dv_ (v - centre_)
  double ds_dv_;
  ChebyshevSeries value_, slope_, curvature_;  // the curve and its first two derivatives by v
  // Coefficients of s^0, s^1, ... of value_, slope_ and curvature_, in groups of four: four of the value,
  // four of the slope, four of the curvature, then the next group. Empty if a series uses Clenshaw's
  // recurrence.
  std::vector<double> blocks_;
  std::optional<CubicSpline> spline_;
};

/// Returns steps + 1 inputs from lo to hi for checking a curve: evenly spaced, but closer together where
/// knots are close together.
std::vector<double> grid_of(Interval range, const std::vector<double>& knots, std::size_t steps);

}  // namespace hystcan::model
