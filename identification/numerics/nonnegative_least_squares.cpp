#include "identification/numerics/nonnegative_least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cstddef>
#include <limits>
#include <tuple>
#include <utility>

#include "base/text.h"

namespace hystcan::identification {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double dependent = 1e-12;  // share of a column's length that is independent of the columns in use
constexpr double no_gain = 10.0 * std::numeric_limits<double>::epsilon();  // of |b|

std::vector<bool> marked(const std::vector<Index>& free, Index columns) {
  std::vector<bool> is_free(static_cast<std::size_t>(columns), false);
  for (const Index j : free) {
    if (j < 0 || j >= columns) refuse("free column ", j, ", expected one of 0 to ", columns - 1);
    if (is_free[static_cast<std::size_t>(j)]) refuse("free column ", j, " occurs twice, expected once");
    is_free[static_cast<std::size_t>(j)] = true;
  }
  return is_free;
}

// A and b, transformed such that the columns in use are triangular.
class Triangular {
 public:
  Triangular(MatrixXd a, VectorXd b) : a_(std::move(a)), b_(std::move(b)), lengths_(a_.colwise().norm()) {}

  Index in_use() const { return static_cast<Index>(used_.size()); }
  Index column(Index place) const { return used_[static_cast<std::size_t>(place)]; }
  bool uses(Index j) const { return std::ranges::find(used_, j) != used_.end(); }
  bool independent(Index j) const { return a_.col(j).tail(below()).norm() > dependent * lengths_[j]; }

  /// Square root of the growth of |b|^2 - |rest|^2 with column j alone; negative if its unknown would be.
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

  /// The unknowns of the columns in use, in the order of entry.
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

  /// Adds the best column to the set in use; returns false if no column lowers the residual.
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

  // Moves towards the least-squares solution of the columns in use until an unknown becomes zero, drops its
  // column, and repeats this until the solution is reached.
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

}  // namespace

Eigen::VectorXd solve_nonnegative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                  const std::vector<Eigen::Index>& free) {
  if (a.rows() != b.size()) refuse(b.size(), " right-hand sides, expected ", a.rows(), ", one for each row");
  if (!a.allFinite() || !b.allFinite()) refuse("a coefficient is not finite, expected finite numbers");
  ActiveSet set(a, b, free);
  // This limit is far above every need. Without it, rounding could exchange the same columns endlessly.
  for (Index exchanges = 30 * (a.cols() + 1); exchanges > 0 && set.improve(); --exchanges) {
  }
  return set.x();
}

}  // namespace hystcan::identification
