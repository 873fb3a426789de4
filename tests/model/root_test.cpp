#include "model/root.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hystcan::model::root_test {
namespace {

Jet cube(double v) { return {v * v * v, 3.0 * v * v, 6.0 * v}; }

constexpr RootTolerance to_rounding{.value = 1e-16};

TEST(RootOfIncreasing, SearchesUpwardsFromTheLowerEnd) {
  EXPECT_NEAR(root_of_increasing(cube, {.begin = 1.0, .end = 5.0}, 27.0, to_rounding).input, 3.0, 1e-15);
}

TEST(RootOfIncreasing, SearchesDownwardsFromTheUpperEnd) {
  EXPECT_NEAR(root_of_increasing(cube, {.begin = 5.0, .end = 1.0}, 27.0, to_rounding).input, 3.0, 1e-15);
}

TEST(RootOfIncreasing, LeavesAPlaceWithoutSlope) {
  EXPECT_NEAR(root_of_increasing(cube, {.begin = 0.0, .end = 5.0}, 27.0, to_rounding).input, 3.0, 1e-14);
}

TEST(RootOfIncreasing, IsTheStartIfItHasTheValue) {
  EXPECT_EQ(root_of_increasing(cube, {.begin = 2.0, .end = 5.0}, 8.0, to_rounding).input, 2.0);
}

TEST(RootOfIncreasing, FindsTheInverseOfASteepCorner) {
  const auto corner = [](double v) {
    return v < 1.0 ? Jet{1e-6 * v, 1e-6, 0.0} : Jet{1e-6 + 1e6 * (v - 1.0), 1e6, 0.0};
  };
  EXPECT_NEAR(root_of_increasing(corner, {.begin = 0.0, .end = 2.0}, 5e5, to_rounding).input, 1.5, 1e-9);
}

TEST(RootOfIncreasing, StopsAfterAStepWithoutError) {
  int jets = 0;
  const auto counted = [&jets](double v) {
    ++jets;
    return cube(v);
  };
  const Root root = root_of_increasing(counted, {.begin = 0.0, .end = 5.0, .guess = 2.999}, 27.0,
                                       {.value = 1e-8, .third = 6.0});
  EXPECT_EQ(jets, 1);
  EXPECT_TRUE(root.is_met);
  EXPECT_NEAR(root.near(root.input), 27.0, 1e-8);
}

TEST(RootOfIncreasing, ContinuesIfTheThirdDerivativeIsUnknown) {
  const Root root =
      root_of_increasing(cube, {.begin = 0.0, .end = 5.0, .guess = 2.9999}, 27.0, {.value = 1e-14});
  EXPECT_EQ(root.near.at, root.input);
}

TEST(LastHalleyStep, LeavesAtMostTheStatedError) {
  const double third = 6.0;
  for (const double from : {0.5, 1.0, 2.0, 4.0})
    for (const double change : {-0.3, -0.1, -1e-2, 1e-3, 1e-2, 0.1, 0.3}) {
      const double wanted = cube(from + change).value;
      const Expansion here(from, cube(from));
      const RootStep step = step_to(wanted, here);
      const double error = std::abs(cube(from + step.length).value - wanted);
      EXPECT_FALSE(is_last(step, here, {.value = 0.99 * error, .third = third})) << from << " " << change;
    }
}

}  // namespace
}  // namespace hystcan::model::root_test
