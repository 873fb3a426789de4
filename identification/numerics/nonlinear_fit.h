// Searches for the unknowns of a nonlinear fit, and computes how well they are determined.
//
// Levenberg's method with linear inequalities: nonlinear least squares from a start near the solution.
//
//   min sum_i w_i (f_i(x) - b_i)^2,     G x >= h
//
// Each step solves the problem linearised at x, with the inequalities and with damping rows
//
//   sqrt(lambda) |J_j| dx_j = 0
//
// If the sum does not fall, lambda increases tenfold and the step is repeated.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

namespace hystcan::identification {

struct NonlinearProblem {
  /// Returns f(x); `nullopt` if x is not a valid model.
  std::function<std::optional<Eigen::VectorXd>(const Eigen::VectorXd& x)> values;
  std::function<Eigen::MatrixXd(const Eigen::VectorXd& x)> jacobian;
  Eigen::VectorXd wanted;  ///< b
  Eigen::VectorXd weight;
  Eigen::MatrixXd g;
  Eigen::VectorXd h;
};

struct Minimum {
  Eigen::VectorXd x;
  double value = 0.0;  ///< value of the function at x; for a fit: weighted sum of squares
};

/// Makes at most `steps` steps that lower the sum, and ends earlier if the sum falls by less than a millionth
/// of itself. The result is never worse than the start. The start must be valid (std::invalid_argument), but
/// it may violate the inequalities.
Minimum improve(const NonlinearProblem& problem, const Eigen::VectorXd& start, int steps);

/// The downhill simplex method, for a few unknowns without derivatives. Starts from `start` with edges
/// `step`. Ends when the values at all corners agree to the relative `tolerance`, or after `evaluations`. A
/// function value that is not finite counts as infinite. The arguments of the function are x and a limit: it
/// may return infinity if its value is the limit or more. `go_on` is called before each move of the simplex;
/// if it returns false, the search ends with the best point so far.
///
/// J. A. Nelder, R. Mead, "A simplex method for function minimization", Computer Journal 7, 1965; with the
/// coefficients of F. Gao, L. Han (2012), which depend on the number of unknowns.
Minimum minimise(const std::function<double(const Eigen::VectorXd&, double)>& function,
                 const Eigen::VectorXd& start, const Eigen::VectorXd& step, double tolerance, int evaluations,
                 const std::function<bool()>& go_on);

/// How well a record determines the unknowns of a fit, with correlated residuals.
///
/// With J the derivatives of the fitted output, r the residuals and g_n = J_n r_n,
///
///   cov = s^2 (J'J)^-1
///   cov = (J'J)^-1 [sum_l w_l sum_n g_n g_{n+l}'] (J'J)^-1,     w_l = 1 - |l| / (L + 1),  L = sqrt(N)
///
/// The second formula is for correlated residuals (Newey and West 1987). The larger standard error of each
/// unknown is used.
///
/// Standard errors to each side that contain 95 % of a normal distribution.
inline constexpr double two_sided_95 = 1.96;

struct Confidence {
  Eigen::VectorXd standard_error;  ///< standard error of the unknown of each column of J
  double variance = 0.0;           ///< s^2, multiplied by the effect of correlated residuals

  /// Sums of squares with a smaller difference are equally good.
  double as_good() const { return two_sided_95 * two_sided_95 * variance; }
};

/// J has a row for each residual. The effect of correlation is computed from the first `unknowns` columns.
Confidence confidence_of(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual,
                         Eigen::Index unknowns);

}  // namespace hystcan::identification
