// The functions of which both reference curves are sums, for thresholds v_lo, v_hi:
//
//   f_0^A(v) = sum a_i B_i(v)                              i = 0 ... n
//   f_0^D(v) = f_0^A(v) + sum q_i G_i(v)                   G = M B,  M (n x (n + 1)) such that G(v_hi) = 0
//   theta    = (a_0 ... a_n, q_1 ... q_n)
//
// The curves meet at the upper threshold for every theta. For polynomials B_i = T_i and G_i = 1 - T_i; for
// splines (model/cubic_spline.h) G_i is B_i without as much of B_n as B_i has at v_hi.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/hysteresis_parameters.h"

namespace hystcan::identification {

/// The k of both directions, 1 / input unit.
struct Pace {
  double k_ascending = 0.0;
  double k_descending = 0.0;

  double k(model::Direction direction) const {
    return direction == model::Direction::ascending ? k_ascending : k_descending;
  }
};

/// A polynomial of some order, or a cubic spline with these knots (input units); how distances along a branch
/// count.
struct CurveShape {
  int order = 1;
  std::vector<double> knots;                         ///< empty: a polynomial
  std::optional<model::CubicSpline> input_map = {};  ///< h, with the same knots; none: h(v) = v

  static CurveShape polynomial(int order) { return {order, {}}; }
  static CurveShape spline(std::vector<double> knots) { return {3, std::move(knots)}; }
  /// The spline with an input map: `share` of it follows `course`, which never falls, the rest is h(v) = v.
  /// It maps both ends of `observed` to themselves.
  CurveShape mapped(const std::function<double(double)>& course, model::Interval observed,
                    double share) const;

  bool is_spline() const { return !knots.empty(); }
  int coefficients() const {  ///< of one curve
    return is_spline() ? static_cast<int>(knots.size()) + 2 : order + 1;
  }
  std::string text() const;  ///< "order 5", "a spline of 8 pieces and an input map"
};

class CurveBasis {
 public:
  CurveBasis(CurveShape shape, model::Interval thresholds);

  const model::Interval& thresholds() const { return thresholds_; }
  Eigen::Index size() const { return shape_.coefficients(); }  ///< n + 1
  Eigen::Index unknowns() const { return 2 * size() - 1; }     ///< of theta
  /// h(v), of which differences are distances along a branch; and h'(v).
  double place(double input) const { return shape_.input_map ? shape_.input_map->value(input) : input; }
  double stretch(double input) const { return shape_.input_map ? shape_.input_map->slope(input) : 1.0; }

  /// B_0 ... B_n at `input`, and their derivatives by the input.
  void values(double input, Eigen::Ref<Eigen::VectorXd> row) const;
  void slopes(double input, Eigen::Ref<Eigen::VectorXd> row) const;

  /// The row of theta for a sum of rows of B (or of B') on a reference curve.
  Eigen::VectorXd row(model::Direction direction, const Eigen::VectorXd& sum) const;
  /// The same as a matrix.
  Eigen::MatrixXd rows(model::Direction direction) const;
  /// (f_0^D - f_0^A) / (2 (1 - t)) at t = (v - v_lo) / (v_hi - v_lo), with its limit at t = 1, as a row of
  /// theta.
  Eigen::VectorXd gap(double t) const;

  /// theta of the curves f^A = f^D = 1 and f^A = f^D = 2 t - 1, and of those with gap() = 1 and f^A = 0.
  Eigen::VectorXd constant() const;
  Eigen::VectorXd line() const;
  Eigen::VectorXd open() const;

  /// A small quadratic form in theta: coefficients that the samples do not determine become zero
  /// (polynomials) or straight (splines). In samples.
  Eigen::MatrixXd regularisation() const;

  /// The model with the two curves of theta.
  model::HysteresisParameters parameters(const Eigen::VectorXd& theta, const Pace& pace) const;

 private:
  void of_splines(double input, double model::Jet::*part, Eigen::Ref<Eigen::VectorXd>& row) const;
  model::ReferenceCurve curve(const Eigen::VectorXd& coefficients) const;

  CurveShape shape_;
  model::Interval thresholds_;
  Eigen::MatrixXd gaps_;  // M
};

/// T_0 ... T_n at `input`.
void chebyshev_row(model::Interval thresholds, double input, Eigen::Ref<Eigen::VectorXd> row);

}  // namespace hystcan::identification
