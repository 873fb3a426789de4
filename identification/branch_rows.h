// Outputs and slopes along a path for a given k, as rows of the linear problem in theta. theta is the vector
// of the unknown coefficients of the reference curves:
//
//   theta    = (a_0 ... a_n, q_1 ... q_n)
//   f_0^A(v) = sum a_i T_i(s)                           s = (2 v - v_lo - v_hi) / (v_hi - v_lo)
//   f_0^D(v) = f_0^A(v) + sum q_i (1 - T_i(s))
//
// The curves meet at the upper threshold for every theta. On each branch of a path
//
//   x = f_0(v) + c - S phi(|v - v_s|)
//
// c and S are linear in theta (model/hysteresis.h). Each branch has one row for c and one for S, which are
// computed at its reversal.
#pragma once

#include <Eigen/Core>

#include "identification/path.h"
#include "model/hysteresis_parameters.h"

namespace hystcan::identification {

/// The k of both directions, 1 / input unit.
struct Pace {
  double k_ascending = 0.0;
  double k_descending = 0.0;

  double k(model::Direction direction) const {
    return direction == model::Direction::ascending ? k_ascending : k_descending;
  }
};

class BranchRows {
 public:
  BranchRows(const Path& path, model::Interval thresholds, Eigen::Index order, const Pace& pace);

  auto offset(std::size_t branch) const { return offset_.col(static_cast<Eigen::Index>(branch)); }  // c
  auto convergence(std::size_t branch) const {
    return convergence_.col(static_cast<Eigen::Index>(branch));
  }  // S
  /// dx/dv at `input` on a branch of the path.
  Eigen::VectorXd slope(const PathBranch& shape, std::size_t branch, double input) const;

 private:
  model::Interval thresholds_;
  Eigen::Index order_;
  Pace pace_;
  Eigen::MatrixXd offset_, convergence_;  // a column for each branch
};

/// T_0 ... T_n at `input`.
void chebyshev_row(model::Interval thresholds, double input, Eigen::Ref<Eigen::VectorXd> row);
/// T_0' ... T_n', the derivatives by the input.
void chebyshev_slope_row(model::Interval thresholds, double input, Eigen::Ref<Eigen::VectorXd> row);

/// A reference curve as a row of theta, from the row of T or T'. `one` is 1 for values and 0 for slopes.
Eigen::VectorXd curve_row(model::Direction direction, const Eigen::VectorXd& basis, double one);

/// The model parameters with the two curves of theta.
model::HysteresisParameters parameters_of(const Eigen::VectorXd& theta, model::Interval thresholds,
                                          const Pace& pace);

}  // namespace hystcan::identification
