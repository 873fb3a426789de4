// Computes outputs and slopes along a path, for a given convergence rate k, as rows of a linear problem in
// the vector theta. theta contains the coefficients of the reference curves (curve_basis.h). On each branch
// of a path, the output is
//
//   x = f_0(v) + c - S phi(d),    d = |h(v) - h(v_s)|,    phi(d) = (1 - e^{-k d}) / k
//
//   v, v_s   input, and input at the start of the branch
//   f_0      reference curve of the branch's direction
//   h        input map; h(v) = v if the model has none
//   c, S     constants of the branch: offset and coefficient (model/hysteresis.h)
//
// c and S are linear in theta. Each branch therefore has one row for c and one row for S, which are computed
// at the reversal where the branch starts.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "identification/curve_basis.h"
#include "identification/path.h"

namespace hystcan::identification {

class BranchRows {
 public:
  /// Computes the two rows of each branch of `path`: for its offset c and its coefficient S in the output
  /// f_0(v) + c - S phi(d). `basis` must exist as long as the object.
  BranchRows(const Path& path, const CurveBasis& basis, const Pace& pace);

  // Return the two rows of a branch with the output f_0(v) + c - S phi(d). The product of the row with theta
  // (the coefficients of the reference curves) is c for offset(), and S for convergence().
  auto offset(std::size_t branch) const { return offset_.col(static_cast<Eigen::Index>(branch)); }
  auto convergence(std::size_t branch) const { return convergence_.col(static_cast<Eigen::Index>(branch)); }
  /// Returns the row for the slope dx/dh of a branch at `input`: the derivative of the output x by the value
  /// h of the input map. The product of the row with theta (the coefficients of the reference curves) is this
  /// slope. `shape` is the branch, and `branch` is its index in Path::branches.
  Eigen::VectorXd slope(const PathBranch& shape, std::size_t branch, double input) const;

 private:
  const CurveBasis& basis_;
  Pace pace_;
  Eigen::MatrixXd offset_, convergence_;  // rows of c and of S, stored as columns: one for each branch
};

}  // namespace hystcan::identification
