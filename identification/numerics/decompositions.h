// Decompositions of a matrix that solve linear least squares.
#pragma once

#include <Eigen/Core>
#include <Eigen/QR>
#include <utility>

namespace hystcan::identification {

/// Solutions of smallest norm, by the complete orthogonal decomposition of a matrix:  A P = Q [T 0; 0 0] Z.
///
/// G. H. Golub, C. F. Van Loan, "Matrix Computations", section 5.5. The templates of Eigen that this takes
/// are large: they are compiled here, and not in each source that solves a linear system.
class OrthogonalDecomposition {
 public:
  /// Of a matrix of any shape. A pivot below `rank_tolerance` of the largest one counts as zero.
  explicit OrthogonalDecomposition(const Eigen::MatrixXd& a, double rank_tolerance);

  Eigen::Index rank() const { return decomposed_.rank(); }
  /// The shortest of all x that minimise |A x - b|.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  /// A^+ (Moore, Penrose).
  Eigen::MatrixXd pseudo_inverse() const;

 private:
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposed_;
};

/// A tall matrix as the product of orthonormal columns and a triangle, by modified Gram-Schmidt:  A = Q R.
///
/// With b as one more column, the solution of least squares is as accurate as with Householder's reflections
/// (A. Bjorck, "Solving linear least squares problems by Gram-Schmidt orthogonalization", BIT 7, 1967). For a
/// few columns of many rows it costs a product of vectors and a sum of vectors for each pair of columns.
class OrthonormalColumns {
 public:
  /// A column that depends on those before it, to 1e-15 of its length, becomes zero.
  explicit OrthonormalColumns(Eigen::MatrixXd columns);

  /// The x that minimises |A x - b|, with 0 for the columns that depend on others; and b - A x.
  std::pair<Eigen::VectorXd, Eigen::VectorXd> solve(Eigen::VectorXd b) const;
  /// Replaces each column of `b` by its part that is orthogonal to A.
  void remove_from(Eigen::Ref<Eigen::MatrixXd> b) const;

 private:
  Eigen::MatrixXd q_, r_;
};

}  // namespace hystcan::identification
