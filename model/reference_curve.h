// Reference curves: the increasing polynomials f_0^A and f_0^D that shape every hysteresis loop.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

namespace hystcan::model {

/// Input range [lo, hi] of a curve, lo < hi, in input units.
struct Interval {
  double lo = 0.0;
  double hi = 1.0;

  double span() const { return hi - lo; }
  bool contains(double v) const { return lo <= v && v <= hi; }
};

enum class Basis { power, chebyshev };
constexpr auto words(Basis) { return std::to_array<std::string_view>({"power", "chebyshev"}); }

/// A function at one input: its value and its first two derivatives.
struct Jet {
  double value = 0.0;
  double slope = 0.0;
  double curvature = 0.0;
};

/// A Chebyshev series on s in [-1, 1]. It is evaluated as a polynomial in s, four terms at a time, if that
/// loses less than four bits of accuracy: if the sum of the |coefficients| of s^j is at most 16 times that of
/// the T_j. Otherwise Clenshaw's recurrence is used; it is slower, but as well conditioned at order 20 as at
/// order 1.
class ChebyshevSeries {
 public:
  explicit ChebyshevSeries(std::vector<double> coefficients);

  double operator()(double s) const { return powers_.empty() ? clenshaw(s) : in_powers(s); }
  const std::vector<double>& coefficients() const { return chebyshev_; }
  const std::vector<double>& powers() const { return powers_; }  ///< of s^0, s^1, ...; empty or 4 n numbers
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

/// A polynomial on an interval, always stored in the Chebyshev basis of that interval:
///
///   f(v) = sum c_j T_j(s),    s = (2 v - lo - hi) / (hi - lo)
///
/// T_j are the Chebyshev polynomials of the first kind.
class ReferenceCurve {
 public:
  /// Zero on [0, 1], a placeholder. No Hysteresis accepts it.
  ReferenceCurve() : ReferenceCurve(Basis::power, {0.0}, {0.0, 1.0}) {}

  /// `coefficients` of v^0, v^1, ... (power) or of T_0, T_1, ... (chebyshev).
  /// Throws std::invalid_argument if they are empty, more than 33 or not finite, or if not lo < hi.
  ReferenceCurve(Basis basis, const std::vector<double>& coefficients, Interval domain);

  double value(double v) const { return value_(ds_dv_ * (v - centre_)); }
  double slope(double v) const { return slope_(ds_dv_ * (v - centre_)); }          ///< df/dv
  double curvature(double v) const { return curvature_(ds_dv_ * (v - centre_)); }  ///< d2f/dv2
  Jet jet(double v) const {
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
  int order() const { return static_cast<int>(chebyshev_coefficients().size()) - 1; }
  const std::vector<double>& chebyshev_coefficients() const { return value_.coefficients(); }

 private:
  Interval domain_;
  double centre_;  // s = ds_dv (v - centre)
  double ds_dv_;
  ChebyshevSeries value_, slope_, curvature_;  // derivatives by v
  std::vector<double> blocks_;  // their coefficients of s^j, in groups of four: value, slope, curvature; ...
};

}  // namespace hystcan::model
