// Reference curves: the increasing polynomials f_0^A and f_0^D that shape every hysteresis loop.
#pragma once

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

/// f(v) = sum c_j T_j(s),  s = (2 v - lo - hi) / (hi - lo),  T_j the Chebyshev polynomials of the first kind.
///
/// Whatever basis the coefficients come in, the curve is kept and evaluated in the Chebyshev basis of its
/// interval, where order 20 is as well conditioned as order 1.
class ReferenceCurve {
 public:
  /// Zero on [0, 1]: a place to be filled. No Hysteresis accepts it.
  ReferenceCurve() : ReferenceCurve(Basis::power, {0.0}, {0.0, 1.0}) {}

  /// `coefficients` of v^0, v^1, ... (power) or of T_0, T_1, ... (chebyshev).
  /// Throws std::invalid_argument where they are empty, more than 33 or not finite, or the interval is not lo
  /// < hi.
  ReferenceCurve(Basis basis, const std::vector<double>& coefficients, Interval domain);

  double value(double v) const;
  double slope(double v) const;      ///< df/dv
  double curvature(double v) const;  ///< d2f/dv2

  const Interval& domain() const { return domain_; }
  int order() const { return static_cast<int>(chebyshev_.size()) - 1; }
  const std::vector<double>& chebyshev_coefficients() const { return chebyshev_; }

 private:
  Interval domain_;
  double centre_ = 0.0;  // s = ds_dv (v - centre)
  double ds_dv_ = 1.0;
  std::vector<double> chebyshev_;
  std::vector<double> value_pairs_;  // Chebyshev coefficients of f, df/dv and d2f/dv2, an even number of them
  std::vector<double> slope_pairs_;
  std::vector<double> curvature_pairs_;
};

}  // namespace hystcan::model
