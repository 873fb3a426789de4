// Least squares with unknowns that must not be negative: the active-set method of Lawson and Hanson.
//
//   min |A x - b|,     x_j >= 0 unless j is free
//
// Columns enter the set in use one by one; the column that lowers the residual most is first. A column leaves
// the set if its unknown would become negative. Reflections and rotations keep the columns in use triangular
// in their order of entry; an exchange costs O(rows * columns). At the end, with g = A^T (b - A x),
//
//   g_j = 0               j in use
//   g_j <= 0, x_j = 0     j not in use
//
// A column that depends on those in use (to 1e-12 of its length) does not enter: if A does not determine
// x, the result is one of the best x. For a tall A, pass its triangle
// (identification/numerics/least_squares.h).
//
// C. L. Lawson, R. J. Hanson, "Solving Least Squares Problems", 1974, chapter 23.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace hystcan::identification {

/// `free`: columns whose unknown may have either sign. Throws std::invalid_argument if the sizes of `a`
/// and `b` differ, if a number is not finite, or if `free` contains an invalid column or the same column
/// twice.
Eigen::VectorXd solve_nonnegative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                  const std::vector<Eigen::Index>& free = {});

}  // namespace hystcan::identification
