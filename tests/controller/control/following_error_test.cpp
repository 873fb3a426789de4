// The following error at its bound, and the cycles with an unknown slope of the reference.
#include "controller/control/following_error.h"

#include <gtest/gtest.h>

#include <limits>

namespace hystcan::controller::following_error_test {
namespace {

using std::chrono::milliseconds;

constexpr double cycle_s = 1.0 / 1024.0;

TEST(FollowingErrorBound, MayBeReachedButNotExceededInBothDirections) {
  const FollowingError::Config config{.error_um = 1.0};
  EXPECT_TRUE(FollowingError(config).step(5.0, 6.0, cycle_s));
  EXPECT_TRUE(FollowingError(config).step(5.0, 4.0, cycle_s));
  EXPECT_FALSE(FollowingError(config).step(5.0, 6.001, cycle_s));
  EXPECT_FALSE(FollowingError(config).step(5.0, 3.999, cycle_s));
}

TEST(FollowingErrorBound, GrowsByTheLagInBothDirections) {
  for (const double step_um : {1.0, -1.0}) {
    FollowingError watch({.error_um = 1.0, .lag = milliseconds(125)});  // 128 cycles
    watch.step(0.0, 0.0, cycle_s);
    EXPECT_TRUE(watch.step(step_um, -127.9 * step_um, cycle_s));
    EXPECT_TRUE(watch.step(2 * step_um, 2 * step_um - 128.9 * step_um, cycle_s));
    EXPECT_FALSE(watch.step(3 * step_um, 3 * step_um - 129.1 * step_um, cycle_s));
  }
}

TEST(FollowingErrorBound, DoesNotGrowByTheLagIfTheReferenceRests) {
  FollowingError watch({.error_um = 1.0, .lag = milliseconds(125)});
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(watch.step(50.0, 50.9, cycle_s));
  EXPECT_FALSE(watch.step(50.0, 51.1, cycle_s));
}

TEST(FollowingErrorBound, DoesNotGrowIfNoTimeHasPassed) {
  FollowingError watch({.error_um = 1.0, .lag = milliseconds(125)});
  watch.step(0.0, 0.0, cycle_s);
  EXPECT_FALSE(watch.step(1.05, 0.0, 0.0));
}

TEST(FollowingErrorBound, DoesNotGrowByTheStepIntoTheFirstCycle) {
  EXPECT_FALSE(FollowingError({.error_um = 1.0, .lag = milliseconds(125)}).step(10.0, 0.0, cycle_s));
}

TEST(FollowingErrorBound, IsExceededByNan) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(FollowingError({.error_um = 1.0}).step(nan, 0.0, cycle_s));
  EXPECT_FALSE(FollowingError({.error_um = 1.0}).step(0.0, nan, cycle_s));
}

TEST(FollowingError, TripsOnlyAfterTheConfiguredCyclesInARow) {
  FollowingError watch({.error_um = 1.0, .lag = {}, .cycles = 3});
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(watch.step(0.0, i % 3 == 2 ? 0.0 : 2.0, cycle_s));
  watch.step(0.0, 2.0, cycle_s);
  EXPECT_TRUE(watch.step(0.0, 2.0, cycle_s));
  EXPECT_FALSE(watch.step(0.0, 2.0, cycle_s));
}

TEST(FollowingErrorRestart, ClearsTheCyclesAndTheLastReference) {
  FollowingError watch({.error_um = 1.0, .lag = milliseconds(125), .cycles = 2});
  watch.step(0.0, 2.0, cycle_s);
  watch.restart();
  EXPECT_TRUE(watch.step(10.0, 0.0, cycle_s)) << "the first cycle in a row";
  EXPECT_FALSE(watch.step(10.0, 0.0, cycle_s));
}

}  // namespace
}  // namespace hystcan::controller::following_error_test
