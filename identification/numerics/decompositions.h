// Decompositions of a matrix that solve linear least squares.
#pragma once

#include <Eigen/Core>
#include <utility>

namespace hystcan::identification {

// The following functions use the complete orthogonal decomposition of a matrix A of any shape and rank. With
// it, they find the rank of A or solve a least-squares problem. A pivot below `rank_tolerance` of the largest
// pivot counts as zero.
//
// G. H. Golub, C. F. Van Loan, "Matrix Computations", section 5.5. The required templates of Eigen take long
// to compile. They are compiled once, here, and not in each source that solves a linear system.

Eigen::Index rank_of(const Eigen::MatrixXd& a, double rank_tolerance);
/// Returns the x that minimises |A x - b|. If several x do, returns the shortest of them.
Eigen::VectorXd shortest_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double rank_tolerance);
/// Returns the pseudo-inverse of A (Moore, Penrose).
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a, double rank_tolerance);

/// A tall matrix A as a product A = Q R: Q has orthonormal columns, and R is an upper triangle. The method is
/// modified Gram-Schmidt.
///
/// The class solves least-squares problems with the matrix A and a right side b. Because b is treated like
/// one more column, the solution is as accurate as with Householder's reflections (A. Bjorck, "Solving linear
/// least squares problems by Gram-Schmidt orthogonalization", BIT 7, 1967). For a few columns with many rows,
/// the method is fast: it needs one product and one sum of vectors for each pair of columns.
class OrthonormalColumns {
 public:
  /// Decomposes the matrix. A column that depends on the columns before it, to 1e-15 of its length, is
  /// replaced by zero.
  explicit OrthonormalColumns(Eigen::MatrixXd columns);

  /// Returns the x that minimises |A x - b|, and the residual b - A x. The x of a dependent column is 0.
  std::pair<Eigen::VectorXd, Eigen::VectorXd> solve(Eigen::VectorXd b) const;
  /// Subtracts from each column of `b` its projection onto the columns of A. The result is orthogonal to A.
  void remove_from(Eigen::Ref<Eigen::MatrixXd> b) const;

 private:
  Eigen::MatrixXd q_, r_;
};

}  // namespace hystcan::identification
