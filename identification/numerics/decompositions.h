// Decompositions of a matrix that solve linear least squares.
#pragma once

#include <Eigen/Core>
#include <utility>

namespace hystcan::identification {

// These functions use the complete orthogonal decomposition of a matrix of any shape,  A P = Q [T 0; 0 0] Z.
// A pivot below `rank_tolerance` of the largest one counts as zero.
//
// G. H. Golub, C. F. Van Loan, "Matrix Computations", section 5.5. The required templates of Eigen are large:
// they are compiled here once, not in each source that solves a linear system.

Eigen::Index rank_of(const Eigen::MatrixXd& a, double rank_tolerance);
/// Returns the shortest x that minimises |A x - b|.
Eigen::VectorXd shortest_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double rank_tolerance);
/// Returns the pseudo-inverse A^+ (Moore, Penrose).
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a, double rank_tolerance);

/// A tall matrix as the product of orthonormal columns and a triangle, by modified Gram-Schmidt:  A = Q R.
///
/// With b as one more column, the solution of least squares is as accurate as with Householder's reflections
/// (A. Bjorck, "Solving linear least squares problems by Gram-Schmidt orthogonalization", BIT 7, 1967). For a
/// few columns of many rows it costs one product and one sum of vectors for each pair of columns.
class OrthonormalColumns {
 public:
  /// A column that depends on the columns before it, to 1e-15 of its length, becomes zero.
  explicit OrthonormalColumns(Eigen::MatrixXd columns);

  /// Returns the x that minimises |A x - b|, with 0 for the columns that depend on others; and b - A x.
  std::pair<Eigen::VectorXd, Eigen::VectorXd> solve(Eigen::VectorXd b) const;
  /// Replaces each column of `b` by its part that is orthogonal to A.
  void remove_from(Eigen::Ref<Eigen::MatrixXd> b) const;

 private:
  Eigen::MatrixXd q_, r_;
};

}  // namespace hystcan::identification
