// The basis functions of both reference curves, between the thresholds v_lo and v_hi:
//
//   f_0^A(v) = sum a_i B_i(v)                              ascending curve, i = 0 ... n
//   f_0^D(v) = f_0^A(v) + sum q_i G_i(v)                   descending curve, i = 1 ... n
//   G = M B                                                M: matrix of n x (n + 1) numbers with G(v_hi) = 0
//   theta    = (a_0 ... a_n, q_1 ... q_n)                  the unknowns
//
// Because G(v_hi) = 0, the curves meet at the upper threshold for every theta. For polynomials, B_i is the
// Chebyshev polynomial T_i, and G_i = 1 - T_i. For splines (model/cubic_spline.h), G_i = B_i - B_i(v_hi) B_n,
// where B_i is a B-spline.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/hysteresis_parameters.h"

namespace hystcan::identification {

/// The convergence rates k of the rising and of the falling branches, 1 / input unit.
struct Pace {
  double k_ascending = 0.0;
  double k_descending = 0.0;

  double k(model::Direction direction) const {
    return direction == model::Direction::ascending ? k_ascending : k_descending;
  }
};

/// The shape of the reference curves: a polynomial of some order, or a cubic spline with some knots (input
/// units). For splines, it may include an input map, which defines the distance along a branch.
struct CurveShape {
  int order = 1;
  std::vector<double> knots;  ///< knots of a spline, input units; empty for a polynomial
  /// Input map h, a spline with the same knots; `nullopt` means h(v) = v.
  std::optional<model::CubicSpline> input_map = {};

  static CurveShape polynomial(int order) { return {order, {}}; }
  static CurveShape spline(std::vector<double> knots) { return {3, std::move(knots)}; }
  /// Returns this spline shape with an input map. The map is a mixture: the fraction `share` of it follows
  /// the function `course`, which must not fall, and the rest is h(v) = v. The map does not change the two
  /// ends of `observed`.
  CurveShape mapped(const std::function<double(double)>& course, model::Interval observed,
                    double share) const;

  bool is_spline() const { return !knots.empty(); }
  int coefficients() const {  ///< number of coefficients of one curve
    return is_spline() ? static_cast<int>(knots.size()) + 2 : order + 1;
  }
  /// Returns a description, for example "order 5" or "a spline of 8 pieces and an input map".
  std::string text() const;
};

class CurveBasis {
 public:
  CurveBasis(CurveShape shape, model::Interval thresholds);

  const model::Interval& thresholds() const { return thresholds_; }
  Eigen::Index size() const { return shape_.coefficients(); }  ///< number of basis functions (n + 1)
  Eigen::Index unknowns() const { return 2 * size() - 1; }     ///< number of unknowns (size of theta)
  /// Return the input map h(v) and its derivative h'(v). The difference of two h(v) is the distance along a
  /// branch.
  double place(double input) const { return shape_.input_map ? shape_.input_map->value(input) : input; }
  double stretch(double input) const { return shape_.input_map ? shape_.input_map->slope(input) : 1.0; }

  /// Compute all basis functions at `input`, and their derivatives by the input.
  void values(double input, Eigen::Ref<Eigen::VectorXd> row) const;
  void slopes(double input, Eigen::Ref<Eigen::VectorXd> row) const;

  /// Returns a row whose product with the unknowns theta is the value of one reference curve at an input.
  /// `sum`: basis functions at this input, computed by values(). With the derivatives from slopes(), the
  /// product is the slope of the curve. With a sum over several inputs, the product is the sum of the values
  /// (or slopes).
  Eigen::VectorXd row(model::Direction direction, const Eigen::VectorXd& sum) const;
  /// Returns the matrix that converts basis functions to a row: the product of this matrix with the basis
  /// functions at an input equals the result of row() for these basis functions.
  Eigen::MatrixXd rows(model::Direction direction) const;
  /// Returns the coefficients of the gap between the two curves as a function of the unknowns theta: the
  /// product of the result with theta is the quotient
  ///
  ///   (f_0^D - f_0^A) / (2 (1 - t))        at the relative input t = (v - v_lo) / (v_hi - v_lo)
  ///
  /// The difference of the curves is divided by 1 - t because it is zero at t = 1. There, the product is the
  /// limit of this quotient.
  Eigen::VectorXd gap(double t) const;

  /// Each of these functions returns theta, the vector of the coefficients of both curves, for one pair of
  /// simple curves. t is the relative input, from 0 at the lower threshold to 1 at the upper one.
  /// constant(): both curves are 1. line(): both curves are 2 t - 1. open(): the curves form an open loop;
  /// the ascending curve is 0, and the descending curve is 2 - 2 t.
  Eigen::VectorXd constant() const;
  Eigen::VectorXd line() const;
  Eigen::VectorXd open() const;

  /// Returns the matrix R of a small penalty theta' R theta on the unknowns theta. A fit adds the penalty to
  /// its sum of squares, once per sample. The penalty makes undetermined coefficients of polynomials zero,
  /// and undetermined parts of splines straight.
  Eigen::MatrixXd regularisation() const;

  /// Returns the parameters of the model whose two curves have the unknowns theta.
  model::HysteresisParameters parameters(const Eigen::VectorXd& theta, const Pace& pace) const;

 private:
  void of_splines(double input, double model::Jet::*part, Eigen::Ref<Eigen::VectorXd>& row) const;
  model::ReferenceCurve curve(const Eigen::VectorXd& coefficients) const;

  CurveShape shape_;
  model::Interval thresholds_;
  Eigen::MatrixXd gaps_;  // matrix M: the gap functions are G = M B, with the basis functions B
};

/// Computes the Chebyshev polynomials of order 0, 1, ... at `input`, one for each element of `row`.
void chebyshev_row(model::Interval thresholds, double input, Eigen::Ref<Eigen::VectorXd> row);

}  // namespace hystcan::identification
