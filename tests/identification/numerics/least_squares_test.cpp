#include "identification/numerics/least_squares.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

namespace hystcan::identification::least_squares_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class Numbers {
 public:
  explicit Numbers(unsigned seed) : engine_(seed) {}
  double operator()() { return normal_(engine_); }
  MatrixXd matrix(Index rows, Index columns) {
    return MatrixXd::NullaryExpr(rows, columns, [this] { return (*this)(); });
  }
  VectorXd vector(Index rows) { return matrix(rows, 1); }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

LeastSquares gathered(const MatrixXd& a, const VectorXd& b) {
  LeastSquares sum(a.cols());
  for (Index i = 0; i < a.rows(); ++i) sum.add(a.row(i).transpose(), b[i]);
  return sum;
}

// The indices of the columns (or rows) whose bit is set.
std::vector<Index> chosen(unsigned bits, Index count) {
  std::vector<Index> some;
  for (Index i = 0; i < count; ++i)
    if (bits >> i & 1U) some.push_back(i);
  return some;
}

// The smallest residual of all subsets of columns with a solution that is not negative.
double best_nonnegative(const MatrixXd& a, const VectorXd& b) {
  double best = b.norm();
  for (unsigned bits = 1; bits < 1U << a.cols(); ++bits) {
    const std::vector<Index> some = chosen(bits, a.cols());
    const MatrixXd part = a(Eigen::seqN(0, a.rows()), some);
    const VectorXd x = part.colPivHouseholderQr().solve(b);
    if ((x.array() >= 0.0).all()) best = std::min(best, (part * x - b).norm());
  }
  return best;
}

// The smallest residual of all subsets of inequalities, solved as equations, whose solution meets the others.
double best_within(const MatrixXd& a, const VectorXd& b, const MatrixXd& g, const VectorXd& h) {
  double best = std::numeric_limits<double>::infinity();
  const Index p = a.cols();
  for (unsigned bits = 0; bits < 1U << g.rows(); ++bits) {
    const std::vector<Index> some = chosen(bits, g.rows());
    const auto n = static_cast<Index>(some.size());
    if (n > p) continue;
    MatrixXd kkt = MatrixXd::Zero(p + n, p + n);
    VectorXd right(p + n);
    kkt.topLeftCorner(p, p) = a.transpose() * a;
    kkt.topRightCorner(p, n) = g(some, Eigen::seqN(0, p)).transpose();
    kkt.bottomLeftCorner(n, p) = g(some, Eigen::seqN(0, p));
    right << a.transpose() * b, h(some);
    const VectorXd x = kkt.fullPivLu().solve(right).head(p);
    if (((g * x - h).array() >= -1e-9).all()) best = std::min(best, (a * x - b).norm());
  }
  return best;
}

TEST(LeastSquares, GivesTheSameResultRowByRowAsAllAtOnce) {
  Numbers number(1);
  for (const Index rows : {7, 8, 31, 32, 33, 500}) {
    const MatrixXd a = number.matrix(rows, 7);
    const VectorXd b = number.vector(rows);
    const VectorXd expected = a.colPivHouseholderQr().solve(b);
    const Fit fit = gathered(a, b).solve();
    EXPECT_LT((fit.x - expected).norm(), 1e-10 * expected.norm());  // rounding, times a condition below 1e5
    EXPECT_NEAR(fit.residual, (a * expected - b).norm(), 1e-12 * b.norm());
  }
}

TEST(LeastSquares, CountsARowOfWeightFourFourTimesAndARowOfWeightZeroNever) {
  Numbers number(2);
  const MatrixXd a = number.matrix(20, 3);
  const VectorXd b = number.vector(20);
  LeastSquares weighted(3), repeated(3);
  for (Index i = 0; i < a.rows(); ++i) {
    const int times = i % 3 == 0 ? 4 : i % 3 == 1 ? 1 : 0;
    weighted.add(a.row(i).transpose(), b[i], times);
    for (int n = 0; n < times; ++n) repeated.add(a.row(i).transpose(), b[i]);
  }
  EXPECT_LT((weighted.solve().x - repeated.solve().x).norm(), 1e-13);
  EXPECT_NEAR(weighted.solve().residual, repeated.solve().residual, 1e-13);
}

TEST(LeastSquares, GivesTheShortestSolutionIfTheRowsDoNotDetermineIt) {
  LeastSquares sum(3);
  sum.add(Eigen::Vector3d(1.0, 1.0, 0.0), 2.0);
  sum.add(Eigen::Vector3d(2.0, 2.0, 0.0), 4.0);
  EXPECT_LT((sum.solve().x - Eigen::Vector3d(1.0, 1.0, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(sum.solve().residual, 0.0, 1e-12);
}

TEST(LeastSquares, RefusesInvalidRowsAndInequalities) {
  EXPECT_THROW(LeastSquares(0), std::invalid_argument);
  LeastSquares sum(2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(sum.add(Eigen::Vector3d(1, 2, 3), 1.0), std::invalid_argument);
  EXPECT_THROW(sum.add(Eigen::Vector2d(1, nan), 1.0), std::invalid_argument);
  EXPECT_THROW(sum.add(Eigen::Vector2d(1, 2), nan), std::invalid_argument);
  EXPECT_THROW(sum.add(Eigen::Vector2d(1, 2), 1.0, -1.0), std::invalid_argument);
  EXPECT_THROW(sum.solve_nonnegative({2}), std::invalid_argument);
  EXPECT_THROW(sum.solve_nonnegative({0, 0}), std::invalid_argument);
  EXPECT_THROW(sum.solve_with_inequalities(MatrixXd::Ones(1, 3), VectorXd::Ones(1)), std::invalid_argument);
  EXPECT_THROW(sum.solve_with_inequalities(MatrixXd::Ones(1, 2), VectorXd::Ones(2)), std::invalid_argument);
}

TEST(NonnegativeLeastSquares, IsTheBestOfAllSubsetsOfColumns) {
  Numbers number(3);
  for (int n = 0; n < 300; ++n) {
    const Index p = 1 + n % 7;
    const MatrixXd a = number.matrix(p + n % 5, p);
    const VectorXd b = number.vector(a.rows());
    const Fit fit = gathered(a, b).solve_nonnegative();
    EXPECT_GE(fit.x.minCoeff(), 0.0);
    EXPECT_NEAR(fit.residual, best_nonnegative(a, b), 1e-10 * b.norm());
  }
}

TEST(NonnegativeLeastSquares, IsOptimalWithFreeAndDependentColumns) {
  Numbers number(4);
  for (int n = 0; n < 20; ++n) {
    MatrixXd a = number.matrix(120, 60).cwiseAbs();
    a.col(10) = a.col(11);
    a.col(20).setZero();
    a.col(30) = a.col(31) + a.col(32);
    const VectorXd b = number.vector(120);
    const Fit fit = gathered(a, b).solve_nonnegative({0, 5});
    const VectorXd gradient = a.transpose() * (b - a * fit.x);
    const double rounding = 1e-11 * a.norm() * b.norm();
    for (Index j = 0; j < 60; ++j) {
      const bool free = j == 0 || j == 5;
      EXPECT_TRUE(free || fit.x[j] >= 0.0);
      EXPECT_GE(gradient[j], free || fit.x[j] > 0.0 ? -rounding : -1e300);
      EXPECT_LE(gradient[j], rounding);
    }
  }
}

TEST(ConstrainedLeastSquares, IsTheBestOfAllSetsOfActiveInequalities) {
  Numbers number(6);
  int at_a_limit = 0;
  for (int n = 0; n < 300; ++n) {
    const Index p = 1 + n % 5;
    const MatrixXd a = number.matrix(p + 3, p), g = number.matrix(1 + n % 7, p);
    const VectorXd b = number.vector(a.rows());
    const VectorXd inside = number.vector(p);
    const VectorXd h = g * inside - number.vector(g.rows()).cwiseAbs();
    const Fit fit = gathered(a, b).solve_with_inequalities(g, h);
    EXPECT_GE((g * fit.x - h).minCoeff(), -1e-9);  // rounding, times a condition below 1e5
    EXPECT_NEAR(fit.residual, best_within(a, b, g, h), 1e-8 * b.norm());
    if ((g * fit.x - h).minCoeff() < 1e-9) ++at_a_limit;
  }
  EXPECT_GT(at_a_limit, 100);
}

TEST(ConstrainedLeastSquares, MeetsManyInequalitiesInAllUnits) {
  // An increasing polynomial is fitted to noisy points of a curve with a flat step: 300 slopes >= 0.
  for (const double unit : {1e-6, 1.0, 1e6}) {
    Numbers number(7);
    constexpr Index p = 9;
    MatrixXd a(1000, p), g = MatrixXd::Zero(300, p);
    VectorXd b(1000);
    for (Index i = 0; i < a.rows(); ++i) {
      const double s = -1.0 + 2.0 * static_cast<double>(i) / 999.0;
      for (Index j = 0; j < p; ++j) a(i, j) = std::pow(s, static_cast<double>(j));
      b[i] = unit * (std::tanh(8.0 * (s - 0.5)) + std::tanh(8.0 * (s + 0.5)) + 0.05 * number());
    }
    for (Index i = 0; i < g.rows(); ++i) {
      const double s = -1.0 + 2.0 * static_cast<double>(i) / 299.0;
      for (Index j = 1; j < p; ++j)
        g(i, j) = static_cast<double>(j) * std::pow(s, static_cast<double>(j - 1));
    }
    const LeastSquares sum = gathered(a, b);
    const Fit loose = sum.solve();
    const Fit fit = sum.solve_with_inequalities(g, VectorXd::Zero(300));
    EXPECT_LT((g * loose.x).minCoeff(), -0.1 * unit);
    EXPECT_GE((g * fit.x).minCoeff(), -1e-11 * unit);
    EXPECT_GT(fit.residual, loose.residual);
    // Stationary: the gradient is a non-negative combination of the active inequalities.
    const VectorXd gradient = a.transpose() * (a * fit.x - b);
    const VectorXd slopes = g * fit.x;
    std::vector<Index> active;
    for (Index i = 0; i < g.rows(); ++i)
      if (slopes[i] < 1e-9 * unit) active.push_back(i);
    const MatrixXd tight = g(active, Eigen::seqN(0, g.cols())).transpose();
    const VectorXd multipliers = solve_nonnegative(tight, gradient);
    EXPECT_LT((tight * multipliers - gradient).norm(), 1e-8 * (a.transpose() * b).norm());
  }
}

TEST(ConstrainedLeastSquares, MeetsTheInequalitiesIfTheRowsDoNotDetermineTheSolution) {
  LeastSquares sum(2);  // determines only x_0 + x_1 = 1
  for (int i = 0; i < 5; ++i) sum.add(Eigen::Vector2d(1.0, 1.0), 1.0);
  MatrixXd g(1, 2);
  g << 1.0, -1.0;
  const Fit fit = sum.solve_with_inequalities(g, VectorXd::Constant(1, 3.0));
  EXPECT_LT((fit.x - Eigen::Vector2d(2.0, -1.0)).norm(), 1e-6);  // pulled to zero by 1e-7
}

TEST(ConstrainedLeastSquares, RefusesContradictoryInequalities) {
  Numbers number(9);
  LeastSquares sum = gathered(number.matrix(10, 2), number.vector(10));
  MatrixXd g(2, 2);
  g << 1.0, 1.0, -1.0, -1.0;
  EXPECT_THROW(sum.solve_with_inequalities(g, Eigen::Vector2d(1.0, 1.0)), std::invalid_argument);
  EXPECT_NO_THROW(sum.solve_with_inequalities(g, Eigen::Vector2d(1.0, -1.0)));  // an equation
  EXPECT_THROW(sum.solve_with_inequalities(MatrixXd::Zero(1, 2), VectorXd::Ones(1)), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::identification::least_squares_test
