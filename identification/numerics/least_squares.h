// Linear least squares. Rows are added one by one; the memory does not grow with the number of rows.
//
//   min sum_i w_i (a_i . x - b_i)^2,     optionally with  x_j >= 0  or with  G x >= h
//
// Rows are collected in blocks. Each full block is reduced, together with the previous triangle, to the
// triangle of its QR decomposition (Householder):
//
//   sqrt(w) [A b] = Q [R c; 0 d],     sum = |R x - c|^2 + d^2
//
// With p unknowns, the memory is O(p^2) and a row costs O(p^2).
//
// Inequalities.  With z = R x - c the problem is a least-distance problem,
//
//   min |z|,     G R^-1 z >= h - G R^-1 c
//
// Its dual is a non-negative least squares problem, which finds the active inequalities. These are then
// solved as equations, so that they hold to rounding (magnified by the condition of R in the step back to x).
//
// C. L. Lawson, R. J. Hanson, "Solving Least Squares Problems", 1974, chapters 23 and 27.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace hystcan::identification {

/// Solves with unknowns that must not be negative, by the active-set method of Lawson and Hanson.
///
///   min |A x - b|,     x_j >= 0 unless j is free
///
/// Columns enter the set in use one by one; the column that lowers the residual most is first. A column
/// leaves the set if its unknown would become negative. Reflections and rotations keep the columns in use
/// triangular in their order of entry; an exchange costs O(rows * columns). At the end, with g = A^T (b - A
/// x),
///
///   g_j = 0               j in use
///   g_j <= 0, x_j = 0     j not in use
///
/// A column that depends on the columns in use (to 1e-12 of its length) does not enter: if A does not
/// determine x, the result is one of the best x. For a tall A, LeastSquares is faster.
///
/// `free`: columns whose unknown may have either sign. Throws std::invalid_argument if the sizes of `a`
/// and `b` differ, if a number is not finite, or if `free` contains an invalid column or the same column
/// twice.
Eigen::VectorXd solve_nonnegative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                  const std::vector<Eigen::Index>& free = {});

struct Fit {
  Eigen::VectorXd x;
  double residual = 0.0;  ///< square root of the weighted sum of squares over all rows
};

struct Triangle {
  Eigen::MatrixXd r;      ///< triangle R, p x p for p unknowns
  Eigen::VectorXd right;  ///< c
  double rest = 0.0;      ///< d, the norm of the residual of the best x

  double residual(const Eigen::VectorXd& x) const;
};

/// If the rows do not determine x (rank to 1e-12, columns scaled to length one), there are several best x:
///   - solve() returns the shortest one, in scaled unknowns;
///   - solve_nonnegative() returns one of them;
///   - solve_with_inequalities() returns nearly the shortest one, because additional rows of 1e-7 of each
///     column's length pull x to zero.
class LeastSquares {
 public:
  /// Throws std::invalid_argument unless there is at least one unknown.
  explicit LeastSquares(Eigen::Index unknowns);

  /// Adds one row; a row of weight 0 is ignored. Throws std::invalid_argument if the size of the row is
  /// not the number of unknowns, if a number is not finite, or if the weight is negative.
  void add(const Eigen::Ref<const Eigen::VectorXd>& row, double right, double weight = 1.0);

  Eigen::Index unknowns() const { return gathered_.cols() - 1; }
  Triangle triangle() const;

  Fit solve() const;
  /// `free`: unknowns that may have either sign.
  Fit solve_nonnegative(const std::vector<Eigen::Index>& free = {}) const;
  /// Solves with G x >= h. Throws std::invalid_argument if sizes do not match, if a number is not finite, or
  /// if the inequalities contradict each other (or meet only 1e6 times as far away as the farthest of them).
  Fit solve_with_inequalities(const Eigen::MatrixXd& g, const Eigen::VectorXd& h) const;

 private:
  Eigen::MatrixXd gathered_;  // sqrt(w) [A b]: the present triangle, then the rows added since
  Eigen::Index filled_ = 0;
};

}  // namespace hystcan::identification
