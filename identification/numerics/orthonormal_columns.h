// A tall matrix as the product of orthonormal columns and a triangle, by modified Gram-Schmidt:  A = Q R.
//
// With b as one more column, the solution of least squares is as accurate as with Householder's reflections
// (A. Bjorck, "Solving linear least squares problems by Gram-Schmidt orthogonalization", BIT 7, 1967). For a few columns
// of many rows it costs a product of vectors and a sum of vectors for each pair of columns.
#pragma once

#include <Eigen/Core>

namespace hystcan::identification {

class OrthonormalColumns {
 public:
  /// A column that depends on those before it, to 1e-15 of its length, becomes zero.
  explicit OrthonormalColumns(Eigen::MatrixXd columns);

  struct Solution {
    Eigen::VectorXd x;         ///< minimises |A x - b|; 0 for the columns that depend on others
    Eigen::VectorXd residual;  ///< b - A x
  };
  Solution solve(Eigen::VectorXd b) const;
  /// Replaces each column of `b` by its part that is orthogonal to A.
  void remove_from(Eigen::Ref<Eigen::MatrixXd> b) const;

 private:
  Eigen::MatrixXd q_, r_;
};

}  // namespace hystcan::identification
