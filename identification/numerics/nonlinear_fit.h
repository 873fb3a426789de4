// Finds the unknowns x of a nonlinear fit, and computes how well they are determined.
//
// improve() uses Levenberg's method with linear inequalities. It needs a start near the solution.
//
//   min sum_i w_i (f_i(x) - b_i)^2,     G x >= h
//
//   f_i(x), b_i   value i of the model, and its wanted value
//   w_i           weight of value i
//
// Each step solves the problem linearised at x, with the inequalities. Additional rows damp the change dx of
// the unknowns:
//
//   sqrt(lambda) |J_j| dx_j = 0        J_j: derivatives by unknown j
//
// If the sum does not decrease, lambda becomes ten times larger and the step is repeated.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

namespace hystcan::identification {

struct NonlinearProblem {
  /// Returns the values of the model, f(x); returns `nullopt` if no valid model has the unknowns x.
  std::function<std::optional<Eigen::VectorXd>(const Eigen::VectorXd& x)> values;
  std::function<Eigen::MatrixXd(const Eigen::VectorXd& x)> jacobian;
  Eigen::VectorXd wanted;  ///< b_i: wanted value for each element of values(x)
  Eigen::VectorXd weight;
  Eigen::MatrixXd g;
  Eigen::VectorXd h;
};

struct Minimum {
  Eigen::VectorXd x;
  double value = 0.0;  ///< value of the minimised function at x; for a fit, the weighted sum of squares
};

/// Lowers the weighted sum of squares in at most `steps` steps. Ends earlier if a step lowers the sum by less
/// than a millionth. The result is never worse than the start. Throws std::invalid_argument if the start is
/// not a valid model. The start may violate the inequalities.
Minimum improve(const NonlinearProblem& problem, const Eigen::VectorXd& start, int steps);

/// Minimises a function of a few unknowns without derivatives, by the downhill simplex method. The simplex
/// begins at `start` and has edges of the lengths `step`. The search ends when the values at all corners
/// agree to the relative `tolerance`, or after `evaluations` calls.
///
/// The arguments of the function are x and a limit. If its value is not below the limit, the function may
/// return infinity. A value that is not finite counts as infinity. `go_on` is called before each move of the
/// simplex; if it returns false, the search ends with the best point so far.
///
/// J. A. Nelder, R. Mead, "A simplex method for function minimization", Computer Journal 7, 1965; with the
/// coefficients of F. Gao, L. Han (2012), which depend on the number of unknowns.
Minimum minimise(const std::function<double(const Eigen::VectorXd&, double)>& function,
                 const Eigen::VectorXd& start, const Eigen::VectorXd& step, double tolerance, int evaluations,
                 const std::function<bool()>& go_on);

/// A normally distributed error is within this many standard errors, to each side, with a probability of 95
/// %.
inline constexpr double two_sided_95 = 1.96;

struct Confidence {
  /// Standard error of each unknown, in the order of the columns of the Jacobian.
  Eigen::VectorXd standard_error;
  double variance = 0.0;  ///< variance of a residual, times a factor for correlated residuals

  /// Returns the largest difference of two sums of squares that is not significant: both fits are then
  /// equally good.
  double as_good() const { return two_sided_95 * two_sided_95 * variance; }
};

/// Computes how well a record determines the unknowns of a fit, if the residuals may be correlated.
/// `jacobian` has a row for each residual and a column for each unknown. `variance` depends on the first
/// `unknowns` columns only.
///
/// With J the Jacobian, J_n its row n, r the N residuals, s^2 their variance and g_n = J_n r_n, there are two
/// formulas for the covariance of the unknowns:
///
///   cov = s^2 (J'J)^-1
///   cov = (J'J)^-1 [sum_l w_l sum_n g_n g_{n+l}'] (J'J)^-1,     w_l = 1 - |l| / (L + 1),  L = sqrt(N)
///
/// The second formula is for correlated residuals (Newey and West 1987). Each unknown gets the larger
/// standard error of the two.
Confidence confidence_of(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual,
                         Eigen::Index unknowns);

}  // namespace hystcan::identification
