#include "identification/numerics/least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <utility>

#include "base/text.h"
#include "identification/numerics/decompositions.h"

namespace hystcan::identification {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
// A column of A counts as dependent on the columns that the active-set method uses, if its part that is
// orthogonal to these columns is shorter than this share of its length.
constexpr double dependent = 1e-12;
// A column of A whose unknown must not be negative is used only if it lowers |A x - b|^2 by more than the
// square of this share of |b|.
constexpr double no_gain = 10.0 * std::numeric_limits<double>::epsilon();

std::vector<bool> marked(const std::vector<Index>& free, Index columns) {
  std::vector<bool> is_free(static_cast<std::size_t>(columns), false);
  for (const Index j : free) {
    if (j < 0 || j >= columns) refuse("free column ", j, ", expected one of 0 to ", columns - 1);
    if (is_free[static_cast<std::size_t>(j)]) refuse("free column ", j, " occurs twice, expected once");
    is_free[static_cast<std::size_t>(j)] = true;
  }
  return is_free;
}

// The matrix A and the right side b, transformed so that the columns in use are an upper triangle.
class Triangular {
 public:
  Triangular(MatrixXd a, VectorXd b) : a_(std::move(a)), b_(std::move(b)), lengths_(a_.colwise().norm()) {}

  Index in_use() const { return static_cast<Index>(used_.size()); }
  Index column(Index place) const { return used_[static_cast<std::size_t>(place)]; }
  bool uses(Index j) const { return std::ranges::find(used_, j) != used_.end(); }
  bool independent(Index j) const { return a_.col(j).tail(below()).norm() > dependent * lengths_[j]; }

  /// Returns a measure of how much column j, added alone, would lower the residual: the square root of the
  /// decrease of the squared residual. Returns a negative number if the unknown of the column would be
  /// negative.
  double gain(Index j) const {
    const auto left = a_.col(j).tail(below());
    return left.dot(b_.tail(below())) / left.norm();
  }

  void enter(Index j) {
    const Index n = below();
    VectorXd essential(n - 1), work(a_.cols());
    double tau = 0.0, beta = 0.0;
    a_.col(j).tail(n).makeHouseholder(essential, tau, beta);
    a_.bottomRows(n).applyHouseholderOnTheLeft(essential, tau, work.data());
    b_.tail(n).applyHouseholderOnTheLeft(essential, tau, work.data());
    a_.col(j).tail(n - 1).setZero();
    used_.push_back(j);
  }

  void drop(Index place) {
    used_.erase(used_.begin() + place);
    for (Index i = place; i < in_use(); ++i) {
      Eigen::JacobiRotation<double> rotation;
      rotation.makeGivens(a_(i, column(i)), a_(i + 1, column(i)));
      a_.applyOnTheLeft(i, i + 1, rotation.adjoint());
      b_.applyOnTheLeft(i, i + 1, rotation.adjoint());
      a_(i + 1, column(i)) = 0.0;
    }
  }

  /// Returns the x that minimises |A x - b| with only the columns in use. The elements of x are in the order
  /// of the enter() calls for these columns.
  VectorXd solution() const {
    const Index n = in_use();
    MatrixXd triangle(n, n);
    for (Index i = 0; i < n; ++i) triangle.col(i) = a_.col(column(i)).head(n);
    return triangle.triangularView<Eigen::Upper>().solve(b_.head(n));
  }

 private:
  Index below() const { return a_.rows() - in_use(); }

  MatrixXd a_;
  VectorXd b_;
  VectorXd lengths_;
  std::vector<Index> used_;
};

class ActiveSet {
 public:
  ActiveSet(const MatrixXd& a, const VectorXd& b, const std::vector<Index>& free)
      : triangular_(a, b), is_free_(marked(free, a.cols())), least_gain_(no_gain * b.norm()), x_(a.cols()) {
    x_.setZero();
    for (const Index j : free)
      if (triangular_.independent(j)) triangular_.enter(j);
    settle();
  }

  /// Adds the column that lowers the residual most to the columns in use. Returns false if no column lowers
  /// the residual.
  bool improve() {
    Index best = -1;
    double most = least_gain_;
    for (Index j = 0; j < x_.size(); ++j) {
      if (is_free(j) || triangular_.uses(j) || !triangular_.independent(j)) continue;
      const double gain = triangular_.gain(j);
      if (gain > most) std::tie(best, most) = std::pair(j, gain);
    }
    if (best < 0) return false;
    triangular_.enter(best);
    settle();
    return true;
  }

  const VectorXd& x() const { return x_; }

 private:
  bool is_free(Index j) const { return is_free_[static_cast<std::size_t>(j)]; }

  // Moves x towards the least-squares solution of the columns in use. If an unknown becomes zero on the way,
  // removes its column and continues towards the new solution.
  void settle() {
    while (true) {
      const VectorXd wanted = triangular_.solution();
      Index stopping = -1;
      double share = 1.0;
      for (Index i = 0; i < triangular_.in_use(); ++i) {
        const double from = x_[triangular_.column(i)];
        if (is_free(triangular_.column(i)) || wanted[i] > 0.0) continue;
        const double here = from > 0.0 ? from / (from - wanted[i]) : 0.0;
        if (stopping < 0 || here < share) std::tie(stopping, share) = std::pair(i, here);
      }
      for (Index i = 0; i < triangular_.in_use(); ++i) {
        double& x = x_[triangular_.column(i)];
        x = stopping < 0 ? wanted[i] : x + share * (wanted[i] - x);
        if (stopping >= 0 && !is_free(triangular_.column(i))) x = std::max(x, 0.0);
      }
      if (stopping < 0) return;
      x_[triangular_.column(stopping)] = 0.0;
      triangular_.drop(stopping);
    }
  }

  Triangular triangular_;
  std::vector<bool> is_free_;
  double least_gain_;
  VectorXd x_;
};

constexpr double dependent_tolerance = 1e-12;
constexpr double pull_to_zero = 1e-7;
constexpr double too_far = 1e6;

// Returns the length of each column; returns 1 for a column of zeros.
VectorXd scales(const MatrixXd& r) {
  VectorXd lengths = r.colwise().norm();
  return (lengths.array() > 0.0).select(lengths, 1.0);
}

// Replaces the first `rows` rows by an equivalent upper triangle (QR decomposition). Returns the number of
// rows of the triangle.
Index reduce(MatrixXd& gathered, Index rows) {
  const Index left = std::min(rows, gathered.cols());
  Eigen::Ref<MatrixXd> block = gathered.topRows(rows);
  const Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> in_place(block);
  for (Index j = 0; j + 1 < left; ++j) gathered.col(j).segment(j + 1, left - j - 1).setZero();
  return left;
}

// Inequalities G z >= h. Each row of G has the length one; rows of zeros are removed.
struct Inequalities {
  MatrixXd g;
  VectorXd h;
};

Inequalities normalised(const MatrixXd& g, const VectorXd& h) {
  Inequalities kept{MatrixXd(g.rows(), g.cols()), VectorXd(h.size())};
  Index count = 0;
  for (Index i = 0; i < g.rows(); ++i) {
    const double length = g.row(i).norm();
    if (length == 0.0 && h[i] > 0.0)
      refuse("inequality ", i, " is 0 >= ", h[i], ", expected a right side of 0 or less");
    if (length == 0.0) continue;
    kept.g.row(count) = g.row(i) / length;
    kept.h[count++] = h[i] / length;
  }
  kept.g.conservativeResize(count, Eigen::NoChange);
  kept.h.conservativeResize(count);
  return kept;
}

// Returns the active inequalities: those whose element of `dual`, the solution of the dual problem, is
// positive. In the solution, these inequalities hold as equations.
Inequalities active(const Inequalities& all, const VectorXd& dual) {
  const Index count = (dual.array() > 0.0).count();
  Inequalities selected{MatrixXd(count, all.g.cols()), VectorXd(count)};
  for (Index i = 0, place = 0; i < dual.size(); ++i) {
    if (!(dual[i] > 0.0)) continue;
    selected.g.row(place) = all.g.row(i);
    selected.h[place++] = all.h[i];
  }
  return selected;
}

// Returns the shortest z that satisfies the inequalities G z >= h in `all`. |z| is at least `farthest`, the
// largest element of h, because the rows of G have the length one. Returns z = 0 if `farthest` is at most
// `rounding`. The dual problem uses h / `farthest`, so that its numbers are of order one.
VectorXd least_distance(const Inequalities& all, double rounding) {
  const Index n = all.g.cols();
  const double farthest = all.h.size() == 0 ? 0.0 : all.h.maxCoeff();
  if (farthest <= rounding) return VectorXd::Zero(n);
  MatrixXd dual(n + 1, all.g.rows());
  dual << all.g.transpose(), all.h.transpose() / farthest;
  const VectorXd last_unit = VectorXd::Unit(n + 1, n);
  const VectorXd u = solve_nonnegative(dual, last_unit);
  // `squared` is the squared residual of the dual problem. It equals 1 / (1 + (|z| / farthest)^2), where z is
  // the shortest vector that satisfies all inequalities. If the inequalities contradict each other, no such
  // vector exists, and `squared` is zero except for rounding errors.
  const double squared = (dual * u - last_unit).squaredNorm();
  if (squared * too_far * too_far < 1.0)
    refuse("inequalities contradict each other, expected inequalities with a solution");
  const Inequalities tight = active(all, u);
  return shortest_solution(tight.g, tight.h, dependent_tolerance);
}

}  // namespace

Eigen::VectorXd solve_nonnegative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                  const std::vector<Eigen::Index>& free) {
  if (a.rows() != b.size()) refuse(b.size(), " right-hand sides, expected ", a.rows(), ", one for each row");
  if (!a.allFinite() || !b.allFinite()) refuse("a coefficient is not finite, expected finite numbers");
  ActiveSet set(a, b, free);
  // This limit is far higher than ever needed. Without it, rounding errors could exchange the same columns
  // forever.
  for (Index exchanges = 30 * (a.cols() + 1); exchanges > 0 && set.improve(); --exchanges) {
  }
  return set.x();
}

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
  const VectorXd y = shortest_solution(t.r * scale.cwiseInverse().asDiagonal(), t.right, dependent_tolerance);
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
  if (rank_of(t.r * scale.cwiseInverse().asDiagonal(), dependent_tolerance) < unknowns()) {
    LeastSquares regularised = *this;
    for (Index j = 0; j < unknowns(); ++j)
      regularised.add(VectorXd::Unit(unknowns(), j) * pull_to_zero * scale[j], 0.0);
    t = regularised.triangle();
  }
  const auto upper = t.r.triangularView<Eigen::Upper>();
  // G R^-1: coefficients of the inequalities for the unknown z = R x - c instead of x (least_squares.h).
  const MatrixXd in_z = g.rows() == 0 ? g : MatrixXd(upper.solve<Eigen::OnTheRight>(g));
  const VectorXd limits = h - in_z * t.right;
  const VectorXd z = least_distance(normalised(in_z, limits), 1e-15 * t.right.norm());
  const VectorXd x = upper.solve(z + t.right);
  return {x, whole.residual(x)};
}

}  // namespace hystcan::identification
