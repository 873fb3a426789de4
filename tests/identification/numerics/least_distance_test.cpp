#include "identification/numerics/least_distance.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>

#include "identification/numerics/least_squares.h"

namespace hystcan::identification::least_distance_test {
namespace {

TEST(LeastDistance, MovesToTheNearestPointOfAHalfSpace) {
  LeastDistance shortest(2);
  EXPECT_TRUE(shortest.meet(Eigen::Vector2d(3.0, 4.0), 10.0));
  EXPECT_NEAR((shortest.z() - Eigen::Vector2d(1.2, 1.6)).norm(), 0.0, 1e-14);
}

TEST(LeastDistance, DropsAnInequalityImpliedByANewOne) {
  LeastDistance shortest(2);
  EXPECT_TRUE(shortest.meet(Eigen::Vector2d(1.0, 0.2), 1.0));
  EXPECT_TRUE(shortest.meet(Eigen::Vector2d(1.0, 0.0), 2.0));
  EXPECT_NEAR((shortest.z() - Eigen::Vector2d(2.0, 0.0)).norm(), 0.0, 1e-13) << "of the second one alone";
}

TEST(LeastDistance, ReportsInconsistentInequalities) {
  LeastDistance shortest(3);
  EXPECT_TRUE(shortest.meet(Eigen::Vector3d(1.0, 2.0, -1.0), 1.0));
  EXPECT_FALSE(shortest.meet(Eigen::Vector3d(-1.0, -2.0, 1.0), -0.5));
}

// The oracle solves the same problem by non-negative least squares.
TEST(LeastDistance, IsTheSolutionOfConstrainedLeastSquares) {
  constexpr Eigen::Index unknowns = 6, rows = 12;
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  LeastSquares plain(unknowns);
  for (Eigen::Index i = 0; i < unknowns; ++i) plain.add(Eigen::VectorXd::Unit(unknowns, i), 0.0);
  for (int n = 0; n < 200; ++n) {
    const auto number = [&](Eigen::Index) { return normal(random); };
    const Eigen::MatrixXd g = Eigen::MatrixXd::NullaryExpr(rows, unknowns, [&] { return normal(random); });
    const Eigen::VectorXd inside = Eigen::VectorXd::NullaryExpr(unknowns, number);
    const Eigen::VectorXd h = g * inside - 0.3 * Eigen::VectorXd::NullaryExpr(rows, number).cwiseAbs();
    LeastDistance shortest(unknowns);
    Eigen::Index farthest = 0;
    while ((h - g * shortest.z()).maxCoeff(&farthest) > 1e-12)
      ASSERT_TRUE(shortest.meet(g.row(farthest), h[farthest]));
    EXPECT_LT((shortest.z() - plain.solve_with_inequalities(g, h).x).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace hystcan::identification::least_distance_test
