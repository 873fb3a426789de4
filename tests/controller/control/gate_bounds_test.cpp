// The gate at its bounds: each side of the range, each direction of the slew, and what is not a number.
#include <gtest/gtest.h>

#include <limits>

#include "controller/control/gate.h"

namespace hystcan::controller::gate_bounds_test {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double dt_s = 0.001;

/// The safe drive is no bound: a drive that falls back to it differs from one that is limited.
Gate::Config config() {
  return {.drive_min = -20.0, .drive_max = 120.0, .slew_per_s = 1000.0, .safe_drive = 5.0};
}

TEST(GateBounds, LimitTheRangeBelowAndReportIt) {
  const Gate::Passed passed = Gate::step(config(), -19.9, -30.0, dt_s);
  EXPECT_EQ(passed.drive, -20.0);
  EXPECT_EQ(passed.limits, limit::range);
}

TEST(GateBounds, PassTheBoundsThemselves) {
  for (const double bound : {-20.0, 120.0}) {
    const Gate::Passed passed = Gate::step(config(), bound, bound, dt_s);
    EXPECT_EQ(passed.drive, bound);
    EXPECT_EQ(passed.limits, limit::none);
  }
}

TEST(GateBounds, LimitTheSlewDownwardsAndReportIt) {
  const Gate::Passed passed = Gate::step(config(), 50.0, 20.0, dt_s);
  EXPECT_DOUBLE_EQ(passed.drive, 49.0);
  EXPECT_EQ(passed.limits, limit::slew);
}

TEST(GateBounds, ReportRangeAndSlewTogether) {
  EXPECT_EQ(Gate::step(config(), 50.0, 130.0, dt_s).limits, limit::range | limit::slew);
}

TEST(GateBounds, HoldNoLastDriveOutsideTheRange) {
  EXPECT_EQ(Gate::step(config(), 500.0, not_a_number, dt_s).drive, 120.0);
  EXPECT_EQ(Gate::step(config(), -500.0, not_a_number, dt_s).drive, -20.0);
}

TEST(GateBounds, CountTheSlewFromWithinTheRangeWhereTheLastDriveIsOutside) {
  EXPECT_DOUBLE_EQ(Gate::step(config(), 500.0, 0.0, dt_s).drive, 119.0);
  EXPECT_DOUBLE_EQ(Gate::step(config(), -500.0, 0.0, dt_s).drive, -19.0);
}

TEST(GateBounds, HoldTheLastDriveWhereTheTimeIsNotFinite) {
  for (const double bad_dt_s : {not_a_number, infinite, -infinite}) {
    const Gate::Passed passed = Gate::step(config(), 42.0, 50.0, bad_dt_s);
    EXPECT_EQ(passed.drive, 42.0);
    EXPECT_EQ(passed.limits, limit::not_finite);
  }
}

TEST(GateBounds, HoldTheLastDriveWhereNoTimeHasPassed) {
  const Gate::Passed passed = Gate::step(config(), 42.0, 50.0, 0.0);
  EXPECT_EQ(passed.drive, 42.0);
  EXPECT_EQ(passed.limits, limit::slew);
}

TEST(GateBounds, PassTheSafeDriveWhereTheyAreNotNumbersThemselves) {
  Gate::Config no_lowest = config();
  no_lowest.drive_min = not_a_number;
  Gate::Config no_highest = config();
  no_highest.drive_max = not_a_number;
  for (const Gate::Config& broken : {no_lowest, no_highest}) {
    const Gate::Passed passed = Gate::step(broken, 42.0, 42.0, dt_s);
    EXPECT_EQ(passed.drive, 5.0);
    EXPECT_EQ(passed.limits, limit::not_finite);
  }
}

TEST(GateBounds, EachLimitHasItsOwnName) {
  EXPECT_EQ(limits_to_string(limit::range), "range");
  EXPECT_EQ(limits_to_string(limit::slew), "slew");
  EXPECT_EQ(limits_to_string(limit::not_finite), "not_finite");
  EXPECT_EQ(limits_to_string(limit::model), "model");
  EXPECT_EQ(limits_to_string(limit::not_invertible), "not_invertible");
}

}  // namespace
}  // namespace hystcan::controller::gate_bounds_test
