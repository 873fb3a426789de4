// The downhill simplex of Nelder and Mead, for a handful of unknowns whose derivatives are not to be had.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace hystcan::identification {

struct Minimum {
  Eigen::VectorXd at;
  double value = 0.0;
};

/// Starts from `start` with edges `step`; ends when all corners agree to `tolerance` in value, relatively, or
/// after `evaluations`. A function that is not finite counts as infinite. `go_on`: asked before each
/// evaluation; false ends the search with the best so far.
///
/// J. A. Nelder, R. Mead, "A simplex method for function minimization", Computer Journal 7, 1965; with the
/// coefficients of F. Gao, L. Han (2012), which depend on the number of unknowns.
Minimum minimise(const std::function<double(const Eigen::VectorXd&)>& function, const Eigen::VectorXd& start,
                 const Eigen::VectorXd& step, double tolerance, int evaluations,
                 const std::function<bool()>& go_on);

}  // namespace hystcan::identification
