#include "identification/numerics/least_distance.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

namespace hystcan::identification::least_distance_test {
namespace {

TEST(LeastDistance, MovesToTheNearestPointOfAHalfSpace) {
  LeastDistance shortest(2);
  EXPECT_TRUE(shortest.meet(Eigen::Vector2d(3.0, 4.0), 10.0));
  EXPECT_NEAR((shortest.z() - Eigen::Vector2d(1.2, 1.6)).norm(), 0.0, 1e-14);
}

TEST(LeastDistance, LetsAnInequalityLeaveThatANewOneMakesNeedless) {
  LeastDistance shortest(2);
  EXPECT_TRUE(shortest.meet(Eigen::Vector2d(1.0, 0.2), 1.0));
  EXPECT_TRUE(shortest.meet(Eigen::Vector2d(1.0, 0.0), 2.0));
  EXPECT_NEAR((shortest.z() - Eigen::Vector2d(2.0, 0.0)).norm(), 0.0, 1e-13) << "of the second one alone";
}

TEST(LeastDistance, SaysWhereInequalitiesContradictEachOther) {
  LeastDistance shortest(3);
  EXPECT_TRUE(shortest.meet(Eigen::Vector3d(1.0, 2.0, -1.0), 1.0));
  EXPECT_FALSE(shortest.meet(Eigen::Vector3d(-1.0, -2.0, 1.0), -0.5));
}

}  // namespace
}  // namespace hystcan::identification::least_distance_test
