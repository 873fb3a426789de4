// Outputs and slopes along a path for a given k, as rows of the linear problem in theta. theta contains the
// coefficients of the reference curves (curve_basis.h). On each branch of a path
//   x = f_0(v) + c - S phi(d),    d = |h(v) - h(v_s)|
//
// c and S are linear in theta (model/hysteresis.h). Each branch has one row for c and one for S, computed at
// its reversal.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "identification/curve_basis.h"
#include "identification/path.h"

namespace hystcan::identification {

class BranchRows {
 public:
  /// `basis` must outlive the rows.
  BranchRows(const Path& path, const CurveBasis& basis, const Pace& pace);

  // Return the rows for c and for S of a branch.
  auto offset(std::size_t branch) const { return offset_.col(static_cast<Eigen::Index>(branch)); }
  auto convergence(std::size_t branch) const { return convergence_.col(static_cast<Eigen::Index>(branch)); }
  /// Returns the row for the slope dx/dh at `input` on a branch of the path.
  Eigen::VectorXd slope(const PathBranch& shape, std::size_t branch, double input) const;

 private:
  const CurveBasis& basis_;
  Pace pace_;
  Eigen::MatrixXd offset_, convergence_;  // one column for each branch
};

}  // namespace hystcan::identification
