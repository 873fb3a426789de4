#include "identification/numerics/orthogonal_decomposition.h"

namespace hystcan::identification {

OrthogonalDecomposition::OrthogonalDecomposition(const Eigen::MatrixXd& a, double rank_tolerance) {
  decomposed_.setThreshold(rank_tolerance);
  decomposed_.compute(a);
}

Eigen::VectorXd OrthogonalDecomposition::solve(const Eigen::VectorXd& b) const {
  return decomposed_.solve(b);
}

Eigen::MatrixXd OrthogonalDecomposition::pseudo_inverse() const { return decomposed_.pseudoInverse(); }

}  // namespace hystcan::identification
