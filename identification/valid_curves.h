// Finds the best reference curves of an invertible model for given convergence rates k. This is a convex
// problem.
//
// Both curves must increase and must not cross, and every branch (the output between two turning points of
// the input) must increase. These conditions are inequalities that are linear in theta, the coefficients of
// the curves (regression.h). There are infinitely many inequalities, but only few matter. Therefore the
// inequalities that the present solution violates are added, until the solution violates none (cutting
// planes). If the result is still slightly invalid, it is mixed with a small share of a straight line.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "identification/regression.h"
#include "model/validity.h"

namespace hystcan::identification {

class ValidCurves {
 public:
  /// `scan_steps`: number of grid steps on which the branches are checked (model/validity.h).
  ValidCurves(CurveShape shape, std::size_t scan_steps);

  struct Solution {
    Eigen::VectorXd theta;
    bool valid = false;
    /// 0 if the curves are valid; otherwise the steepest decrease of a curve or branch, as a multiple of the
    /// mean slope.
    double violation = 0.0;
    /// True if solve() ended early because the RMS error is above its limit. The coefficients theta of the
    /// curves are then not final.
    bool beyond_limit = false;
  };
  /// Returns the best curves for which both curves and all branches increase and the curves do not cross.
  /// `output_span` and `input_span` are the ranges of the outputs and of the inputs in all datasets; their
  /// quotient is the mean slope. Ends early if all such curves have an RMS error above `limit`.
  Solution solve(const NormalEquations& system, model::Interval thresholds, const Pace& pace,
                 double output_span, double input_span,
                 double limit = std::numeric_limits<double>::infinity());
  /// Returns the basis functions of the curves in the last solution; their coefficients are Solution::theta.
  const CurveBasis& basis() const { return basis_; }

 private:
  void use(model::Interval thresholds);
  /// Checks the curves with the coefficients `theta`. Returns 0 if both curves and all branches increase and
  /// the curves do not cross; otherwise the steepest decrease, as a multiple of `mean_slope`. `lowest`:
  /// smallest element of the product of curves_ and theta, that is, the smallest slope of the curves or the
  /// smallest gap between them.
  double violation(const Eigen::VectorXd& theta, double lowest, const Pace& pace, double mean_slope);
  void separate_curves(Eigen::VectorXd& theta, double bound) const;
  void mix_with_line(Eigen::VectorXd& theta, double violation, const NormalEquations& system,
                     double least_rise) const;
  void add_cuts(std::vector<model::DecreasingBranch> branches);
  Eigen::VectorXd row_of(const model::DecreasingBranch& cut, const Pace& pace) const;

  CurveShape shape_;
  CurveBasis basis_;
  std::size_t scan_steps_;
  Eigen::Index points_;  // number of grid points on which the curves are checked
  // Conditions on the curves, one in each row: row * theta must be positive. The rows give the slopes of both
  // curves (with the input range scaled to 1) and the gap between them, at each grid point.
  Eigen::MatrixXd curves_;
  // Indices of the conditions (rows of curves_) that earlier solutions did not satisfy. solve() starts with
  // these conditions, because otherwise the next solution would probably violate them too.
  std::vector<Eigen::Index> rows_;
  // Branches that decreased in earlier solutions. solve() requires that each branch increases at its `input`,
  // because the branch will probably decrease again. All inputs are relative: 0 is the lower threshold and 1
  // the upper one.
  std::vector<model::DecreasingBranch> cuts_;
};

}  // namespace hystcan::identification
