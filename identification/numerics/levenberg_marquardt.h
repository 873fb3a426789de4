// Levenberg's method with linear inequalities: nonlinear least squares from a start near the solution.
//
//   min sum_i w_i (f_i(x) - b_i)^2,     G x >= h
//
// Each step solves the problem linearised at x, with the inequalities and with damping rows
//
//   sqrt(lambda) |J_j| dx_j = 0
//
// If the sum does not fall, lambda grows tenfold and the step is repeated.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

namespace hystcan::identification {

struct NonlinearProblem {
  /// f(x); none if x is not a valid model.
  std::function<std::optional<Eigen::VectorXd>(const Eigen::VectorXd& x)> values;
  std::function<Eigen::MatrixXd(const Eigen::VectorXd& x)> jacobian;
  Eigen::VectorXd wanted;  ///< b
  Eigen::VectorXd weight;
  Eigen::MatrixXd g;
  Eigen::VectorXd h;
};

struct NonlinearFit {
  Eigen::VectorXd x;
  double cost = 0.0;  ///< the weighted sum of squares
};

/// Takes at most `steps` steps that lower the sum, and ends earlier if the sum falls by less than a
/// millionth of itself. The result is never worse than the start. The start must be valid
/// (std::invalid_argument), but it may violate the inequalities.
NonlinearFit improve(const NonlinearProblem& problem, const Eigen::VectorXd& start, int steps);

}  // namespace hystcan::identification
