#include "identification/numerics/nonlinear_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

namespace hystcan::identification::levenberg_marquardt_test {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

// x_0 e^{-x_1 t}, not a valid model if x_1 < 0. The truth is 2 e^{-3 t}.
NonlinearProblem decay() {
  const ArrayXd t = ArrayXd::LinSpaced(50, 0.0, 1.0);
  const auto values = [t](const VectorXd& x) -> std::optional<VectorXd> {
    if (x[1] < 0.0) return std::nullopt;
    return VectorXd(x[0] * (-x[1] * t).exp());
  };
  const auto jacobian = [t](const VectorXd& x) {
    MatrixXd columns(t.size(), 2);
    columns.col(0) = (-x[1] * t).exp();
    columns.col(1) = -t * x[0] * (-x[1] * t).exp();
    return columns;
  };
  return {values,
          jacobian,
          2.0 * (-3.0 * t).exp(),
          VectorXd::Ones(t.size()),
          MatrixXd(0, 2),
          VectorXd(VectorXd::Zero(0))};
}

TEST(Levenberg, FindsADecayFromAStartNearby) {
  const Minimum fit = improve(decay(), Vector2d(1.0, 1.0), 50);
  EXPECT_LT((fit.x - Vector2d(2.0, 3.0)).norm(), 1e-12);  // rounding
  EXPECT_LT(fit.value, 1e-24);
}

TEST(Levenberg, StopsAtAnInequality) {
  NonlinearProblem problem = decay();
  problem.g = Eigen::RowVector2d(0.0, -1.0);  // x_1 <= 2
  problem.h = VectorXd::Constant(1, -2.0);
  const Minimum fit = improve(problem, Vector2d(1.0, 1.0), 50);
  EXPECT_NEAR(fit.x[1], 2.0, 1e-12);
  const VectorXd curve = problem.jacobian(fit.x).col(0);  // x_0 is the least-squares solution for this x_1
  EXPECT_NEAR(fit.x[0], curve.dot(problem.wanted) / curve.squaredNorm(),
              1e-6);  // tolerance for the end of the steps
}

TEST(Levenberg, RefusesAnInvalidStart) {
  EXPECT_THROW(improve(decay(), Vector2d(1.0, -1.0), 50), std::invalid_argument);
}

// A bent valley, in two of three unknowns.
double bent(const VectorXd& x) {
  return 1.0 + std::pow(1.0 - x[0], 2) + 10.0 * std::pow(x[1] - x[0] * x[0], 2);
}

Minimum minimum_of(const std::function<double(const VectorXd&, double)>& function) {
  return minimise(function, Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(0.5), 1e-4, 300,
                  [] { return true; });
}

TEST(Simplex, NeedsNoValueBeyondTheLimit) {
  const Minimum all = minimum_of([](const VectorXd& x, double) { return bent(x); });
  const Minimum some = minimum_of([](const VectorXd& x, double limit) {
    const double value = bent(x);
    return value < limit ? value : std::numeric_limits<double>::infinity();
  });
  EXPECT_EQ(some.x, all.x);
}

TEST(Simplex, IgnoresRoundingErrors) {
  int sign = 1;
  const Minimum exact = minimum_of([](const VectorXd& x, double) { return bent(x); });
  const Minimum noisy =
      minimum_of([&](const VectorXd& x, double) { return bent(x) * (1.0 + 1e-12 * (sign = -sign)); });
  EXPECT_EQ(noisy.x, exact.x);
}

}  // namespace
}  // namespace hystcan::identification::levenberg_marquardt_test
