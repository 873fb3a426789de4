// The best curves that make an invertible model, k being given: a convex problem.
//
// That both curves increase and do not cross is linear in theta (branch_rows.h); so is that a branch
// increases, once its turning points are named. Of the infinitely many inequalities few matter: those that
// the solution so far breaks are put in, until none is broken (cutting planes). What is then still a hair's
// breadth from valid is mixed with as much of a straight line.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "identification/branch_rows.h"
#include "identification/regression.h"
#include "model/validity.h"

namespace hystcan::identification {

class ValidCurves {
 public:
  /// `scan_steps`: of the grid that branches are looked for on (model/validity.h).
  ValidCurves(int order, std::size_t scan_steps);

  struct Solution {
    Eigen::VectorXd theta;
    bool valid = false;
    double wrong = 0.0;  ///< where not: the steepest slope the wrong way, in mean slopes
  };
  /// `output_span`: of the dataset; `input_span`: that it belongs to.
  Solution solve(const NormalEquations& system, model::Interval thresholds, const Pace& pace,
                 double output_span, double input_span);

 private:
  struct Cut {  // a branch that must increase at an input, all in spans of the thresholds from the lower one
    model::Direction direction = model::Direction::ascending;
    double start = 0.0, target = 1.0, input = 0.0;
  };

  double wrong(const Eigen::VectorXd& theta, model::Interval thresholds, const Pace& pace, double mean_slope);
  void draw_apart(Eigen::VectorXd& theta, double bound) const;
  void mix_with_line(Eigen::VectorXd& theta, double wrong, const NormalEquations& system,
                     double least_rise) const;
  bool add_broken_curve_rows(const Eigen::VectorXd& theta, double bound,
                             std::vector<Eigen::VectorXd>& rows) const;
  void add_cuts(const std::vector<model::DecreasingBranch>& branches, model::Interval thresholds);
  Eigen::VectorXd row_of(const Cut& cut, model::Interval thresholds, const Pace& pace) const;

  Eigen::Index order_;
  std::size_t scan_steps_;
  Eigen::Index points_;     // of the grid that curves are looked at on
  Eigen::MatrixXd curves_;  // rows: slope of both curves and the gap between them, on a grid, span 1
  std::vector<Cut> cuts_;   // met so far: what was broken once is likely to be broken again
};

}  // namespace hystcan::identification
