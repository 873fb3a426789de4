// Computes outputs and slopes along a path, for a given convergence rate k, as rows of a linear problem in
// the vector theta. theta contains the coefficients of the reference curves (curve_basis.h). On each branch
// of a path, the output is
//
//   x = f_0(v) + c - S phi(d),    d = |h(v) - h(v_s)|
//
// (symbols: model/hysteresis.h). The offset c and the coefficient S of a branch are linear in theta. Each
// branch therefore has one row for c and one row for S, which are computed at its reversal.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "identification/curve_basis.h"
#include "identification/path.h"

namespace hystcan::identification {

class BranchRows {
 public:
  /// Computes the rows for the offset c and the coefficient S of all branches of `path`. `basis` must exist
  /// as long as the object.
  BranchRows(const Path& path, const CurveBasis& basis, const Pace& pace);

  // Return the rows whose products with theta are the offset c and the coefficient S of a branch.
  auto offset(std::size_t branch) const { return offset_.col(static_cast<Eigen::Index>(branch)); }
  auto convergence(std::size_t branch) const { return convergence_.col(static_cast<Eigen::Index>(branch)); }
  /// Returns the row whose product with theta is the slope of the output at `input`, per unit of the input
  /// map h. `branch` is the index of the branch in the path, and `shape` the branch itself.
  Eigen::VectorXd slope(const PathBranch& shape, std::size_t branch, double input) const;

 private:
  const CurveBasis& basis_;
  Pace pace_;
  Eigen::MatrixXd offset_, convergence_;  // rows of c and of S, stored as columns: one for each branch
};

}  // namespace hystcan::identification
