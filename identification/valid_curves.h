// The best curves of an invertible model for a given k: a convex problem.
//
// Both curves must increase and must not cross; these conditions are linear in theta (regression.h). A branch
// with given turning points must increase; this condition is linear too. Only few of the infinitely many
// inequalities matter: inequalities that the present solution violates are added until none is violated
// (cutting planes). If the result is still slightly invalid, it is mixed with a small share of a straight
// line.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "identification/regression.h"
#include "model/validity.h"

namespace hystcan::identification {

class ValidCurves {
 public:
  /// `scan_steps`: size of the grid on which branches are checked (model/validity.h).
  ValidCurves(CurveShape shape, std::size_t scan_steps);

  struct Solution {
    Eigen::VectorXd theta;
    bool valid = false;
    double violation = 0.0;     ///< 0 if valid; else the steepest decrease, in mean slopes
    bool beyond_limit = false;  ///< theta is not final
  };
  /// `output_span`, `input_span`: spans of the dataset's outputs and inputs. Ends early if the RMS error of
  /// every valid theta is above `limit`.
  Solution solve(const NormalEquations& system, model::Interval thresholds, const Pace& pace,
                 double output_span, double input_span,
                 double limit = std::numeric_limits<double>::infinity());
  /// The basis of theta in the last solution.
  const CurveBasis& basis() const { return basis_; }

 private:
  void use(model::Interval thresholds);
  /// Returns by how much theta violates the conditions (Solution::violation). `lowest`: smallest element of
  /// curves_ * theta.
  double violation(const Eigen::VectorXd& theta, double lowest, const Pace& pace, double mean_slope);
  void separate_curves(Eigen::VectorXd& theta, double bound) const;
  void mix_with_line(Eigen::VectorXd& theta, double violation, const NormalEquations& system,
                     double least_rise) const;
  void add_cuts(std::vector<model::DecreasingBranch> branches);
  Eigen::VectorXd row_of(const model::DecreasingBranch& cut, const Pace& pace) const;

  CurveShape shape_;
  CurveBasis basis_;
  std::size_t scan_steps_;
  Eigen::Index points_;     // size of the grid on which curves are checked
  Eigen::MatrixXd curves_;  // rows: slopes of both curves, for a span of 1, and their gap, on this grid
  std::vector<Eigen::Index> rows_;  // rows of curves_ that were violated once: likely to be violated again
  // Branches found so far that must increase at `input`: a cut that was violated once is likely to be
  // violated again. Their inputs are relative: 0 is the lower threshold and 1 the upper one.
  std::vector<model::DecreasingBranch> cuts_;
};

}  // namespace hystcan::identification
