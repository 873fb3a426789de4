#include "identification/curve_basis.h"

namespace hystcan::identification {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Computes the derivatives of the Chebyshev polynomials T_i by the input, with the polynomials U_i of the
// second kind:
//
//   T_i'(s) = i U_{i-1}(s)        s: input, scaled to -1 .. 1
void chebyshev_slope_row(model::Interval thresholds, double input, Eigen::Ref<VectorXd> row) {
  const double s = (2.0 * input - thresholds.lo - thresholds.hi) / thresholds.span();
  const double ds_dv = 2.0 / thresholds.span();
  double before = 0.0, u = 1.0;
  row[0] = 0.0;
  for (Index i = 1; i < row.size(); ++i) {
    row[i] = static_cast<double>(i) * u * ds_dv;
    const double next = 2.0 * s * u - before;
    before = u;
    u = next;
  }
}

MatrixXd gaps_of(const CurveBasis& basis, bool is_spline) {
  const Index n = basis.size() - 1;
  MatrixXd gaps = MatrixXd::Zero(n, n + 1);
  if (!is_spline) {
    gaps.col(0).setOnes();
    gaps.rightCols(n) = -MatrixXd::Identity(n, n);
    return gaps;
  }
  VectorXd end(n + 1);
  basis.values(basis.thresholds().hi, end);
  gaps.leftCols(n).setIdentity();
  gaps.col(n) = -end.head(n) / end[n];
  return gaps;
}

}  // namespace

void chebyshev_row(model::Interval thresholds, double input, Eigen::Ref<VectorXd> row) {
  const double s = (2.0 * input - thresholds.lo - thresholds.hi) / thresholds.span();
  row[0] = 1.0;
  if (row.size() > 1) row[1] = s;
  for (Index i = 2; i < row.size(); ++i) row[i] = 2.0 * s * row[i - 1] - row[i - 2];
}

// Sets the coefficients of the input map, a B-spline, to the values that the map should have at the Greville
// points of its knots. If these values increase, the map increases everywhere.
CurveShape CurveShape::mapped(const std::function<double(double)>& course, model::Interval observed,
                              double share) const {
  const double low = course(observed.lo), rise = course(observed.hi) - low;
  std::vector<double> places = model::greville_points(knots);
  for (double& place : places)
    place = (1.0 - share) * place + share * (observed.lo + observed.span() * (course(place) - low) / rise);
  CurveShape mapped = *this;
  mapped.input_map.emplace(knots, std::move(places));
  return mapped;
}

std::string CurveShape::text() const {
  if (!is_spline()) return "order " + std::to_string(order);
  return "a spline of " + std::to_string(knots.size() - 1) + " pieces" +
         (input_map ? " and an input map" : "");
}

CurveBasis::CurveBasis(CurveShape shape, model::Interval thresholds)
    : shape_(std::move(shape)), thresholds_(thresholds), gaps_(gaps_of(*this, shape_.is_spline())) {}

void CurveBasis::of_splines(double input, double model::Jet::*part, Eigen::Ref<VectorXd>& row) const {
  const model::BSplines splines = model::bsplines(shape_.knots, input);
  row.setZero();
  for (std::size_t i = 0; i < splines.at.size(); ++i)
    row[static_cast<Index>(splines.first + i)] = splines.at[i].*part;
}

void CurveBasis::values(double input, Eigen::Ref<VectorXd> row) const {
  if (shape_.is_spline()) return of_splines(input, &model::Jet::value, row);
  chebyshev_row(thresholds_, input, row);
}

void CurveBasis::slopes(double input, Eigen::Ref<VectorXd> row) const {
  if (shape_.is_spline()) return of_splines(input, &model::Jet::slope, row);
  chebyshev_slope_row(thresholds_, input, row);
}

// The product of the row with theta = (a, q) is a value of a reference curve. The ascending curve is a . B,
// so that its row is (B, 0). The descending curve is a . B + q . M B, so that its row is (B, M B). B: values
// of the basis functions, or a sum of such values; M: matrix from curve_basis.h.
VectorXd CurveBasis::row(model::Direction direction, const VectorXd& sum) const {
  VectorXd row = VectorXd::Zero(unknowns());
  row.head(size()) = sum;
  if (direction == model::Direction::descending) row.tail(size() - 1).noalias() = gaps_ * sum;
  return row;
}

MatrixXd CurveBasis::rows(model::Direction direction) const {
  MatrixXd rows = MatrixXd::Zero(unknowns(), size());
  rows.topRows(size()).setIdentity();
  if (direction == model::Direction::descending) rows.bottomRows(size() - 1) = gaps_;
  return rows;
}

VectorXd CurveBasis::gap(double t) const {
  VectorXd basis(size()), gap = VectorXd::Zero(unknowns());
  if (t < 1.0 - 1e-9) {
    values(thresholds_.lo + t * thresholds_.span(), basis);
    gap.tail(size() - 1) = gaps_ * basis / (2.0 - 2.0 * t);
  } else {
    slopes(thresholds_.hi, basis);
    gap.tail(size() - 1) = gaps_ * basis * (-0.5 * thresholds_.span());
  }
  return gap;
}

VectorXd CurveBasis::constant() const {
  VectorXd theta = VectorXd::Zero(unknowns());
  if (shape_.is_spline())
    theta.head(size()).setOnes();
  else
    theta[0] = 1.0;
  return theta;
}

VectorXd CurveBasis::line() const {
  VectorXd theta = VectorXd::Zero(unknowns());
  if (!shape_.is_spline()) {
    theta[1] = 1.0;
    return theta;
  }
  const std::vector<double> at = model::greville_points(shape_.knots);
  for (Index i = 0; i < size(); ++i)
    theta[i] = (2.0 * at[static_cast<std::size_t>(i)] - thresholds_.lo - thresholds_.hi) / thresholds_.span();
  return theta;
}

// Returns the unknowns theta of two curves that open towards the lower threshold: the ascending curve is 0,
// and the descending curve is 2 (1 - t) = 1 - (2 t - 1), with the relative input t from 0 to 1. constant()
// contains the coefficients of 1, and line() those of 2 t - 1. For a spline, the second part of theta is
// therefore the difference of these coefficients, without the last one: the curves meet at t = 1.
VectorXd CurveBasis::open() const {
  VectorXd theta = VectorXd::Zero(unknowns());
  if (shape_.is_spline())
    theta.tail(size() - 1) = (constant() - line()).head(size() - 1);
  else
    theta[size()] = 1.0;
  return theta;
}

MatrixXd CurveBasis::regularisation() const {
  // Weight of the square of each coefficient in the penalty theta' R theta. For a polynomial, the weight is
  // larger by the factor 1 + j^2 (j: order of the coefficient).
  constexpr double weak = 1e-11;
  MatrixXd R = MatrixXd::Zero(unknowns(), unknowns());
  const Index n = size() - 1;
  if (!shape_.is_spline()) {
    for (Index i = 0; i < R.rows(); ++i) {
      const auto j = static_cast<double>(i <= n ? i : i - n);
      R(i, i) = weak * (1.0 + j * j);
    }
    return R;
  }
  constexpr double straight = 1e-8;
  R.diagonal().setConstant(weak);
  const auto bend = [&](Index begin, Index count) {
    for (Index i = begin; i + 2 < begin + count; ++i) {
      VectorXd second = VectorXd::Zero(unknowns());
      second[i] = second[i + 2] = 1.0;
      second[i + 1] = -2.0;
      R += straight * second * second.transpose();
    }
  };
  bend(0, n + 1);
  bend(n + 1, n);
  return R;
}

model::ReferenceCurve CurveBasis::curve(const VectorXd& coefficients) const {
  std::vector<double> given(coefficients.begin(), coefficients.end());
  if (shape_.is_spline()) return {model::CubicSpline(shape_.knots, std::move(given)), thresholds_};
  return {model::Basis::chebyshev, given, thresholds_};
}

model::HysteresisParameters CurveBasis::parameters(const VectorXd& theta, const Pace& pace) const {
  const VectorXd rising = theta.head(size());
  model::HysteresisParameters parameters;
  parameters.ascending = curve(rising);
  parameters.descending = curve(rising + gaps_.transpose() * theta.tail(size() - 1));
  parameters.k_ascending = pace.k_ascending;
  parameters.k_descending = pace.k_descending;
  parameters.input_map = shape_.input_map;
  return parameters;
}

}  // namespace hystcan::identification
