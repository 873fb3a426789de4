// Solutions of smallest norm, by the complete orthogonal decomposition of a matrix:  A P = Q [T 0; 0 0] Z.
//
// G. H. Golub, C. F. Van Loan, "Matrix Computations", section 5.5. The templates of Eigen that this takes are
// large: they are compiled here, and not in each source that solves a linear system.
#pragma once

#include <Eigen/QR>

namespace hystcan::identification {

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

}  // namespace hystcan::identification
