// The downhill simplex method of Nelder and Mead, for a few unknowns without derivatives.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace hystcan::identification {

struct Minimum {
  Eigen::VectorXd at;
  double value = 0.0;
};

/// Starts from `start` with edges `step`. Ends when the values at all corners agree to the relative
/// `tolerance`, or after `evaluations`. A function value that is not finite counts as infinite. `go_on` is
/// called before each move of the simplex; false ends the search with the best point so far.
///
/// J. A. Nelder, R. Mead, "A simplex method for function minimization", Computer Journal 7, 1965; with the
/// coefficients of F. Gao, L. Han (2012), which depend on the number of unknowns.
Minimum minimise(const std::function<double(const Eigen::VectorXd&)>& function, const Eigen::VectorXd& start,
                 const Eigen::VectorXd& step, double tolerance, int evaluations,
                 const std::function<bool()>& go_on);

}  // namespace hystcan::identification
