// Linear least squares, gathered row by row in memory that does not grow with the number of rows.
//
//   min sum_i w_i (a_i . x - b_i)^2,     optionally with  x_j >= 0  or with  G x >= h
//
// Rows are gathered in blocks; each full block is reduced with what stood before to the triangle of its QR
// decomposition (Householder), sqrt(w) [A b] = Q [R c; 0 d]: memory O(p^2), a row costs O(p^2), p unknowns.
// The sum is |R x - c|^2 + d^2.
//
// Inequalities.  With z = R x - c the problem is the least distance  min |z|, G R^-1 z >= h - G R^-1 c, whose
// dual is a non-negative least squares problem. The inequalities that it finds active are then met as
// equations, so that they hold to rounding (magnified by the condition of R on the way back to x).
//
// C. L. Lawson, R. J. Hanson, "Solving Least Squares Problems", 1974, chapters 23 and 27.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace hystcan::identification {

struct Fit {
  Eigen::VectorXd x;
  double residual = 0.0;  ///< root of the weighted sum of squares, over all rows
};

struct Triangle {
  Eigen::MatrixXd r;      ///< p x p
  Eigen::VectorXd right;  ///< c
  double rest = 0.0;      ///< d: the residual of the best x

  double residual(const Eigen::VectorXd& x) const;
};

/// Where the rows do not determine x (rank to 1e-12, columns scaled to length one), solve() gives the
/// shortest of the best in scaled unknowns, solve_nonnegative() one of the best, and
/// solve_with_inequalities() nearly the shortest: rows of 1e-7 of each column's length draw it to zero.
class LeastSquares {
 public:
  /// Throws std::invalid_argument where there is not at least one unknown.
  explicit LeastSquares(Eigen::Index unknowns);

  /// One row; weight 0 leaves it out. Throws std::invalid_argument where its size is not that of the
  /// unknowns, a number is not finite or the weight negative.
  void add(const Eigen::Ref<const Eigen::VectorXd>& row, double right, double weight = 1.0);

  Eigen::Index unknowns() const { return gathered_.cols() - 1; }
  Triangle triangle() const;

  Fit solve() const;
  /// `free`: unknowns that may have either sign.
  Fit solve_nonnegative(const std::vector<Eigen::Index>& free = {}) const;
  /// G x >= h. Throws std::invalid_argument where sizes do not match, a number is not finite, or the
  /// inequalities contradict each other (or meet only 1e6 times as far off as the farthest one of them).
  Fit solve_with_inequalities(const Eigen::MatrixXd& g, const Eigen::VectorXd& h) const;

 private:
  Eigen::MatrixXd gathered_;  // sqrt(w) [A b]: the triangle so far, the rows since
  Eigen::Index filled_ = 0;
};

}  // namespace hystcan::identification
