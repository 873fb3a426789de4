// Least squares with unknowns that may not be negative: Lawson and Hanson's active set.
//
//   min |A x - b|,     x_j >= 0 except where j is free
//
// Columns are taken into use one by one, the one that lowers the residual most first, and dropped where their
// unknown would become negative. A is kept turned by reflections and rotations such that the columns in use
// are triangular in their order of entry; an exchange costs O(rows * columns). At the end
//
//   g = A^T (b - A x):     g_j = 0 in use,     g_j <= 0 not in use, x_j = 0
//
// A column that depends on those in use (to 1e-12 of its length) is not taken: where A does not determine x,
// one of the best is found. Give it the triangle of a tall A (identification/numerics/least_squares.h).
//
// C. L. Lawson, R. J. Hanson, "Solving Least Squares Problems", 1974, chapter 23.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace hystcan::identification {

/// `free`: columns whose unknown may have either sign. Throws std::invalid_argument where the sizes of `a`
/// and `b` differ, a number is not finite, or `free` names a column that isn't there or one twice.
Eigen::VectorXd solve_nonnegative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                  const std::vector<Eigen::Index>& free = {});

}  // namespace hystcan::identification
