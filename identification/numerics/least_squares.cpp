#include "identification/numerics/least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "identification/numerics/nonnegative_least_squares.h"
#include "identification/numerics/orthogonal_decomposition.h"

namespace hystcan::identification {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double dependent_tolerance = 1e-12;
constexpr double pull_to_zero = 1e-7;
constexpr double too_far = 1e6;

// The lengths of the columns; 1 if a column is zero.
VectorXd scales(const MatrixXd& r) {
  VectorXd lengths = r.colwise().norm();
  return (lengths.array() > 0.0).select(lengths, 1.0);
}

// Reduces the first `rows` rows in place to an upper triangle. Returns the number of remaining rows.
Index reduce(MatrixXd& gathered, Index rows) {
  const Index left = std::min(rows, gathered.cols());
  Eigen::Ref<MatrixXd> block = gathered.topRows(rows);
  const Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> in_place(block);
  for (Index j = 0; j + 1 < left; ++j) gathered.col(j).segment(j + 1, left - j - 1).setZero();
  return left;
}

// G z >= h with rows of length one, without rows that are zero.
struct Inequalities {
  MatrixXd g;
  VectorXd h;
};

Inequalities normalised(const MatrixXd& g, const VectorXd& h) {
  Inequalities kept{MatrixXd(g.rows(), g.cols()), VectorXd(h.size())};
  Index count = 0;
  for (Index i = 0; i < g.rows(); ++i) {
    const double length = g.row(i).norm();
    if (length == 0.0 && h[i] > 0.0) refuse("inequality ", i, " is 0 >= ", h[i], ", expected 0 or less");
    if (length == 0.0) continue;
    kept.g.row(count) = g.row(i) / length;
    kept.h[count++] = h[i] / length;
  }
  kept.g.conservativeResize(count, Eigen::NoChange);
  kept.h.conservativeResize(count);
  return kept;
}

// The inequalities with dual[i] > 0: row i of G and h_i.
Inequalities active(const Inequalities& all, const VectorXd& dual) {
  const Index count = (dual.array() > 0.0).count();
  Inequalities some{MatrixXd(count, all.g.cols()), VectorXd(count)};
  for (Index i = 0, place = 0; i < dual.size(); ++i) {
    if (!(dual[i] > 0.0)) continue;
    some.g.row(place) = all.g.row(i);
    some.h[place++] = all.h[i];
  }
  return some;
}

// Solves  min |z|, G z >= h.  h is divided by the distance of the farthest inequality, so that |z| is of
// order one. If this distance is only rounding, z = 0 is the solution.
VectorXd least_distance(const Inequalities& all, double rounding) {
  const Index n = all.g.cols();
  const double farthest = all.h.size() == 0 ? 0.0 : all.h.maxCoeff();
  if (farthest <= rounding) return VectorXd::Zero(n);
  MatrixXd dual(n + 1, all.g.rows());
  dual << all.g.transpose(), all.h.transpose() / farthest;
  const VectorXd last_unit = VectorXd::Unit(n + 1, n);
  const VectorXd u = solve_nonnegative(dual, last_unit);
  const double squared = (dual * u - last_unit).squaredNorm();  // 1 / (1 + |z|^2), z scaled
  if (squared * too_far * too_far < 1.0)
    refuse("inequalities contradict each other, expected an x that meets all of them");
  const Inequalities tight = active(all, u);
  return OrthogonalDecomposition(tight.g, dependent_tolerance).solve(tight.h);
}

}  // namespace

double Triangle::residual(const VectorXd& x) const { return std::hypot((r * x - right).norm(), rest); }

LeastSquares::LeastSquares(Index unknowns) {
  if (unknowns < 1) refuse(unknowns, " unknowns, expected at least 1");
  gathered_.resize(4 * (unknowns + 1), unknowns + 1);
}

void LeastSquares::add(const Eigen::Ref<const VectorXd>& row, double right, double weight) {
  if (row.size() != unknowns()) refuse("row of ", row.size(), " coefficients, expected ", unknowns());
  if (!row.allFinite() || !std::isfinite(right)) refuse("row is not finite, expected finite numbers");
  if (!(weight >= 0.0) || !std::isfinite(weight)) refuse("weight is ", weight, ", expected a number >= 0");
  if (weight == 0.0) return;
  if (filled_ == gathered_.rows()) filled_ = reduce(gathered_, filled_);
  gathered_.row(filled_).head(unknowns()) = std::sqrt(weight) * row.transpose();
  gathered_(filled_++, unknowns()) = std::sqrt(weight) * right;
}

Triangle LeastSquares::triangle() const {
  const Index p = unknowns();
  MatrixXd all = MatrixXd::Zero(std::max(filled_, p + 1), p + 1);
  all.topRows(filled_) = gathered_.topRows(filled_);
  reduce(all, all.rows());
  return {all.topLeftCorner(p, p), all.col(p).head(p), std::abs(all(p, p))};
}

Fit LeastSquares::solve() const {
  const Triangle t = triangle();
  const VectorXd scale = scales(t.r);
  const VectorXd y =
      OrthogonalDecomposition(t.r * scale.cwiseInverse().asDiagonal(), dependent_tolerance).solve(t.right);
  const VectorXd x = y.cwiseQuotient(scale);
  return {x, t.residual(x)};
}

Fit LeastSquares::solve_nonnegative(const std::vector<Index>& free) const {
  const Triangle t = triangle();
  const VectorXd x = identification::solve_nonnegative(t.r, t.right, free);
  return {x, t.residual(x)};
}

Fit LeastSquares::solve_with_inequalities(const MatrixXd& g, const VectorXd& h) const {
  if (g.cols() != unknowns()) refuse("inequalities of ", g.cols(), " unknowns, expected ", unknowns());
  if (g.rows() != h.size()) refuse(h.size(), " limits, expected ", g.rows(), ", one for each inequality");
  if (!g.allFinite() || !h.allFinite()) refuse("an inequality is not finite, expected finite numbers");
  const Triangle whole = triangle();
  const VectorXd scale = scales(whole.r);
  Triangle t = whole;
  if (OrthogonalDecomposition(t.r * scale.cwiseInverse().asDiagonal(), dependent_tolerance).rank() <
      unknowns()) {
    LeastSquares regularised = *this;
    for (Index j = 0; j < unknowns(); ++j)
      regularised.add(VectorXd::Unit(unknowns(), j) * pull_to_zero * scale[j], 0.0);
    t = regularised.triangle();
  }
  const auto upper = t.r.triangularView<Eigen::Upper>();
  const MatrixXd in_z = g.rows() == 0 ? g : MatrixXd(upper.solve<Eigen::OnTheRight>(g));  // G R^-1
  const VectorXd limits = h - in_z * t.right;
  const VectorXd z = least_distance(normalised(in_z, limits), 1e-15 * t.right.norm());
  const VectorXd x = upper.solve(z + t.right);
  return {x, whole.residual(x)};
}

}  // namespace hystcan::identification
