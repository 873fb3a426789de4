// Linear least squares. The rows are added one by one; the memory does not grow with the number of rows.
//
//   min sum_i w_i (a_i . x - b_i)^2,     optionally with  x_j >= 0  or with  G x >= h
//
//   x              unknowns
//   a_i, b_i, w_i  coefficients, right side and weight of row i
//
// The rows are collected in blocks. Each full block, together with the triangle so far, is reduced to a new
// triangle R by a QR decomposition (Householder). A and b contain the rows, and the diagonal matrix w the
// weights:
//
//   sqrt(w) [A b] = Q [R c; 0 d],     sum = |R x - c|^2 + d^2
//
// With p unknowns, the memory is O(p^2) and a row costs O(p^2).
//
// Inequalities G x >= h: with z = R x - c, the problem is to find the shortest z (a least-distance problem),
//
//   min |z|,     G R^-1 z >= h - G R^-1 c
//
// The dual of this problem is a non-negative least-squares problem. Its solution shows which inequalities are
// active. The active inequalities are then solved as equations, so that they hold to rounding errors
// (magnified by the condition of R in the step back to x).
//
// C. L. Lawson, R. J. Hanson, "Solving Least Squares Problems", 1974, chapters 23 and 27.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace hystcan::identification {

/// Solves a least-squares problem whose unknowns must not be negative, by the active-set method of Lawson and
/// Hanson.
///
///   min |A x - b|,     x_j >= 0 unless j is in `free`
///
/// The method keeps a set of columns in use. The column that lowers the residual most enters the set next. A
/// column leaves the set if its unknown would become negative. Reflections and rotations keep the columns in
/// use triangular, in the order in which they entered; an exchange costs O(rows * columns). At the end, with
/// g = A^T (b - A x),
///
///   g_j = 0               column j is in use
///   g_j <= 0, x_j = 0     column j is not in use
///
/// A column that depends on the columns in use (to 1e-12 of its length) does not enter. If A does not
/// determine x, the result is therefore one of several best x. For a matrix with many rows, the class
/// LeastSquares is faster.
///
/// `free`: columns whose unknown may be negative. Throws std::invalid_argument if the sizes of `a` and `b`
/// differ, if a number is not finite, or if `free` contains an invalid column or the same column twice.
Eigen::VectorXd solve_nonnegative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                  const std::vector<Eigen::Index>& free = {});

struct Fit {
  Eigen::VectorXd x;
  double residual = 0.0;  ///< square root of the weighted sum of squares over all rows
};

struct Triangle {
  Eigen::MatrixXd r;      ///< upper triangle R from the QR decomposition of the weighted rows; square
  Eigen::VectorXd right;  ///< c: the unknowns x minimise |R x - c|
  double rest = 0.0;      ///< norm of the residual of the best solution

  double residual(const Eigen::VectorXd& x) const;
};

/// Solves a linear least-squares problem whose rows are added one by one. If the rows do not determine all
/// unknowns (rank to 1e-12, columns scaled to length one), several solutions are equally good:
///
///   - solve() returns the shortest of them, measured in scaled unknowns;
///   - solve_nonnegative() returns any of them;
///   - solve_with_inequalities() returns nearly the shortest: additional rows, of 1e-7 of each column's
///     length, pull the unknowns to zero.
class LeastSquares {
 public:
  /// Throws std::invalid_argument if `unknowns` is less than one.
  explicit LeastSquares(Eigen::Index unknowns);

  /// Adds the equation row . x = right with a weight; ignores a row of weight 0. Throws std::invalid_argument
  /// if the row does not have unknowns() coefficients, if a number is not finite, or if the weight is
  /// negative.
  void add(const Eigen::Ref<const Eigen::VectorXd>& row, double right, double weight = 1.0);

  Eigen::Index unknowns() const { return gathered_.cols() - 1; }
  Triangle triangle() const;

  Fit solve() const;
  /// Solves with x >= 0. `free`: indices of unknowns that may be negative.
  Fit solve_nonnegative(const std::vector<Eigen::Index>& free = {}) const;
  /// Solves with the inequalities g x >= h. Throws std::invalid_argument if the sizes do not match, if a
  /// number is not finite, or if the inequalities contradict each other. The inequalities count as
  /// contradictory if every point that satisfies all of them is at least a million times as far from the
  /// origin as the farthest single inequality.
  Fit solve_with_inequalities(const Eigen::MatrixXd& g, const Eigen::VectorXd& h) const;

 private:
  // First the triangle of the earlier rows, then the rows that were added after the last reduction. Each row
  // is sqrt(weight) * (coefficients, right side).
  Eigen::MatrixXd gathered_;
  Eigen::Index filled_ = 0;
};

}  // namespace hystcan::identification
