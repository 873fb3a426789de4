#include "model/root.h"

#include <gtest/gtest.h>

namespace hystcan::model::root_test {
namespace {

Jet cube(double v) { return {v * v * v, 3.0 * v * v, 6.0 * v}; }

constexpr RootTolerance to_rounding{.value = 1e-16, .step = 0.0, .slope = 0.0};

TEST(RootOfIncreasing, SearchesUpwardsFromTheLowerEnd) {
  EXPECT_NEAR(root_of_increasing(cube, {.begin = 1.0, .end = 5.0}, 27.0, to_rounding), 3.0, 1e-15);
}

TEST(RootOfIncreasing, SearchesDownwardsFromTheUpperEnd) {
  EXPECT_NEAR(root_of_increasing(cube, {.begin = 5.0, .end = 1.0}, 27.0, to_rounding), 3.0, 1e-15);
}

TEST(RootOfIncreasing, LeavesAPlaceWithoutSlope) {
  EXPECT_NEAR(root_of_increasing(cube, {.begin = 0.0, .end = 5.0}, 27.0, to_rounding), 3.0, 1e-14);
}

TEST(RootOfIncreasing, IsTheStartIfItHasTheValue) {
  EXPECT_EQ(root_of_increasing(cube, {.begin = 2.0, .end = 5.0}, 8.0, to_rounding), 2.0);
}

TEST(RootOfIncreasing, FindsTheInverseOfASteepCorner) {
  const auto corner = [](double v) {
    return v < 1.0 ? Jet{1e-6 * v, 1e-6, 0.0} : Jet{1e-6 + 1e6 * (v - 1.0), 1e6, 0.0};
  };
  EXPECT_NEAR(root_of_increasing(corner, {.begin = 0.0, .end = 2.0}, 5e5, to_rounding), 1.5, 1e-9);
}

TEST(RootOfIncreasing, StopsAfterAShortStep) {
  int jets = 0;
  const auto counted = [&jets](double v) {
    ++jets;
    return cube(v);
  };
  root_of_increasing(counted, {.begin = 0.0, .end = 5.0, .guess = 2.999}, 27.0,
                     {.value = 0.0, .step = 0.1, .slope = 1.0});
  EXPECT_EQ(jets, 1);
}

}  // namespace
}  // namespace hystcan::model::root_test
