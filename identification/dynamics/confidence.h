// How well a record determines the unknowns of a fit, with correlated residuals.
//
// With J the derivatives of the fitted output, r the residuals and g_n = J_n r_n,
//
//   cov = s^2 (J'J)^-1
//   cov = (J'J)^-1 [sum_l w_l sum_n g_n g_{n+l}'] (J'J)^-1,     w_l = 1 - |l| / (L + 1),  L = sqrt(N)
//
// The second is for correlated residuals (Newey and West 1987); the larger standard error of each unknown is used.
#pragma once

#include <Eigen/Core>

namespace hystcan::identification {

/// 95 % of a normal distribution, on both sides.
inline constexpr double two_sided_95 = 1.96;

struct Confidence {
  Eigen::VectorXd standard_error;  ///< of the unknown of each column of J
  double variance = 0.0;           ///< s^2, multiplied by the effect of correlated residuals

  /// Sums of squares that differ by less are equally good.
  double as_good() const { return two_sided_95 * two_sided_95 * variance; }
};

/// J has a row for each residual. The effect of correlation is that on the first `unknowns` columns.
Confidence confidence_of(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual,
                         Eigen::Index unknowns);

}  // namespace hystcan::identification
