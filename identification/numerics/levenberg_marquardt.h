// Levenberg's method within linear inequalities: nonlinear least squares from a start that is near.
//
//   min sum_i w_i (f_i(x) - b_i)^2,     G x >= h
//
// Each step solves the problem linearised at x, inequalities included, with damping rows
// sqrt(lambda) |J_j| dx_j = 0; where the sum does not fall, lambda grows tenfold and the step is tried again.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

namespace hystcan::identification {

struct NonlinearProblem {
  /// f(x); nothing where x is no valid model.
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

/// At most `steps` steps that lower the sum; ends before where it falls by less than a millionth of itself.
/// Never worse than the start, which must be valid (std::invalid_argument) but may break the inequalities.
NonlinearFit improve(const NonlinearProblem& problem, const Eigen::VectorXd& start, int steps);

}  // namespace hystcan::identification
