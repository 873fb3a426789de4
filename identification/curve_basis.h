// The basis functions of both reference curves, for thresholds v_lo, v_hi:
//
//   f_0^A(v) = sum a_i B_i(v)                              i = 0 ... n
//   f_0^D(v) = f_0^A(v) + sum q_i G_i(v)                   G = M B,  M (n x (n + 1)) such that G(v_hi) = 0
//   theta    = (a_0 ... a_n, q_1 ... q_n)
//
// The curves meet at the upper threshold for every theta. For polynomials B_i = T_i and G_i = 1 - T_i. For
// splines (model/cubic_spline.h) G_i = B_i - B_i(v_hi) B_n.
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

/// The shape of the curves: a polynomial of some order, or a cubic spline with these knots (input units); and
/// the measure of distances along a branch.
struct CurveShape {
  int order = 1;
  std::vector<double> knots;                         ///< empty: a polynomial
  std::optional<model::CubicSpline> input_map = {};  ///< h, with the same knots; empty: h(v) = v

  static CurveShape polynomial(int order) { return {order, {}}; }
  static CurveShape spline(std::vector<double> knots) { return {3, std::move(knots)}; }
  /// Returns the spline with an input map: `share` of it follows `course`, which must not fall; the rest is
  /// h(v) = v. It maps both ends of `observed` to themselves.
  CurveShape mapped(const std::function<double(double)>& course, model::Interval observed,
                    double share) const;

  bool is_spline() const { return !knots.empty(); }
  int coefficients() const {  ///< number of coefficients of one curve
    return is_spline() ? static_cast<int>(knots.size()) + 2 : order + 1;
  }
  std::string text() const;  ///< for example "order 5" or "a spline of 8 pieces and an input map"
};

class CurveBasis {
 public:
  CurveBasis(CurveShape shape, model::Interval thresholds);

  const model::Interval& thresholds() const { return thresholds_; }
  Eigen::Index size() const { return shape_.coefficients(); }  ///< n + 1
  Eigen::Index unknowns() const { return 2 * size() - 1; }     ///< size of theta
  /// Return h(v), whose differences are distances along a branch, and its derivative h'(v).
  double place(double input) const { return shape_.input_map ? shape_.input_map->value(input) : input; }
  double stretch(double input) const { return shape_.input_map ? shape_.input_map->slope(input) : 1.0; }

  /// Compute B_0 ... B_n at `input`, and their derivatives by the input.
  void values(double input, Eigen::Ref<Eigen::VectorXd> row) const;
  void slopes(double input, Eigen::Ref<Eigen::VectorXd> row) const;

  /// Returns the row of theta for a sum of rows of B (or of B') on a reference curve.
  Eigen::VectorXd row(model::Direction direction, const Eigen::VectorXd& sum) const;
  /// Returns the same as a matrix.
  Eigen::MatrixXd rows(model::Direction direction) const;
  /// Returns (f_0^D - f_0^A) / (2 (1 - t)) at t = (v - v_lo) / (v_hi - v_lo), with its limit at t = 1, as a
  /// row of theta.
  Eigen::VectorXd gap(double t) const;

  /// Return theta for f^A = f^D = 1, for f^A = f^D = 2 t - 1, and for curves with gap() = 1 and f^A = 0.
  Eigen::VectorXd constant() const;
  Eigen::VectorXd line() const;
  Eigen::VectorXd open() const;

  /// Returns a small quadratic form in theta, per sample. It makes undetermined coefficients zero
  /// (polynomials), or the curve straight (splines).
  Eigen::MatrixXd regularisation() const;

  /// Returns the model with the two curves of theta.
  model::HysteresisParameters parameters(const Eigen::VectorXd& theta, const Pace& pace) const;

 private:
  void of_splines(double input, double model::Jet::*part, Eigen::Ref<Eigen::VectorXd>& row) const;
  model::ReferenceCurve curve(const Eigen::VectorXd& coefficients) const;

  CurveShape shape_;
  model::Interval thresholds_;
  Eigen::MatrixXd gaps_;  // M, with G = M B
};

/// Computes T_0 ... T_n at `input`.
void chebyshev_row(model::Interval thresholds, double input, Eigen::Ref<Eigen::VectorXd> row);

}  // namespace hystcan::identification
