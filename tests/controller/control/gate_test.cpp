#include "controller/control/gate.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

namespace hystcan::controller::gate_test {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double dt_s = 1e-3;

/// The safe drive is not a bound: a fallback to it differs from a limited drive.
constexpr Gate::Config gate{.drive_min = -20.0, .drive_max = 120.0, .slew_per_s = 1000.0, .safe_drive = 5.0};

TEST(Gate, PassesADriveInRangeAndWithinTheSlewLimit) {
  const Gate::Passed passed = Gate::step(gate, 50.0, 50.5, dt_s);
  EXPECT_EQ(passed.drive, 50.5);
  EXPECT_EQ(passed.limits, limit::none);
}

TEST(Gate, PassesTheBoundsOfTheRange) {
  for (const double bound : {-20.0, 120.0}) {
    const Gate::Passed passed = Gate::step(gate, bound, bound, dt_s);
    EXPECT_EQ(passed.drive, bound);
    EXPECT_EQ(passed.limits, limit::none);
  }
}

TEST(Gate, LimitsTheSlewInBothDirectionsAndReportsIt) {
  for (const double direction : {1.0, -1.0}) {
    const Gate::Passed passed = Gate::step(gate, 50.0, 50.0 + direction * 30.0, dt_s);
    EXPECT_DOUBLE_EQ(passed.drive, 50.0 + direction);
    EXPECT_EQ(passed.limits, limit::slew);
  }
}

TEST(Gate, LimitsTheRangeOnBothSidesAndReportsIt) {
  const Gate::Passed above = Gate::step(gate, 119.9, 130.0, dt_s);
  EXPECT_EQ(above.drive, 120.0);
  EXPECT_EQ(above.limits, limit::range);
  const Gate::Passed below = Gate::step(gate, -19.9, -30.0, dt_s);
  EXPECT_EQ(below.drive, -20.0);
  EXPECT_EQ(below.limits, limit::range);
}

TEST(Gate, ReportsRangeAndSlewTogether) {
  EXPECT_EQ(Gate::step(gate, 50.0, 130.0, dt_s).limits, limit::range | limit::slew);
}

TEST(Gate, HoldsTheLastDriveIfTheRequestedDriveIsNotFinite) {
  for (const double bad : {not_a_number, infinite, -infinite}) {
    const Gate::Passed passed = Gate::step(gate, 42.0, bad, dt_s);
    EXPECT_EQ(passed.drive, 42.0);
    EXPECT_EQ(passed.limits, limit::not_finite);
  }
}

TEST(Gate, HoldsTheLastDriveIfTheTimeIsNotFinite) {
  for (const double bad_dt_s : {not_a_number, infinite, -infinite}) {
    const Gate::Passed passed = Gate::step(gate, 42.0, 50.0, bad_dt_s);
    EXPECT_EQ(passed.drive, 42.0);
    EXPECT_EQ(passed.limits, limit::not_finite);
  }
}

TEST(Gate, HoldsTheLastDriveIfTheTimeDoesNotIncrease) {
  for (const double no_time_s : {0.0, -1.0}) {
    const Gate::Passed passed = Gate::step(gate, 42.0, 50.0, no_time_s);
    EXPECT_EQ(passed.drive, 42.0);
    EXPECT_EQ(passed.limits, limit::slew);
  }
}

TEST(Gate, HoldsNoLastDriveOutsideTheRange) {
  EXPECT_EQ(Gate::step(gate, 500.0, not_a_number, dt_s).drive, 120.0);
  EXPECT_EQ(Gate::step(gate, -500.0, not_a_number, dt_s).drive, -20.0);
}

TEST(Gate, CountsTheSlewFromWithinTheRangeIfTheLastDriveIsOutside) {
  EXPECT_DOUBLE_EQ(Gate::step(gate, 500.0, 0.0, dt_s).drive, 119.0);
  EXPECT_DOUBLE_EQ(Gate::step(gate, -500.0, 0.0, dt_s).drive, -19.0);
}

// The law may request any sequence of drives with any bit patterns.
RC_GTEST_PROP(Gate, PassesOnlyFiniteReachableDrivesInRange, (std::vector<std::uint64_t> bits)) {
  double last = 10.0;
  for (const std::uint64_t pattern : bits) {
    const double requested = std::bit_cast<double>(pattern * 0x9E3779B97F4A7C15u);
    const Gate::Passed passed = Gate::step(gate, last, requested, dt_s);
    RC_ASSERT(std::isfinite(passed.drive));
    RC_ASSERT(passed.drive >= gate.drive_min && passed.drive <= gate.drive_max);
    RC_ASSERT(std::abs(passed.drive - last) <= gate.slew_per_s * dt_s * (1.0 + 1e-12));
    RC_ASSERT((passed.limits == limit::none) == (passed.drive == requested));
    last = passed.drive;
  }
}

TEST(Gate, PassesTheSafeDriveIfTheLastOneIsUnknown) {
  for (const double last : {not_a_number, infinite}) {
    const Gate::Passed passed = Gate::step(gate, last, 80.0, dt_s);
    EXPECT_EQ(passed.drive, gate.safe_drive);
    EXPECT_EQ(passed.limits, limit::not_finite);
  }
}

TEST(Gate, PassesTheSafeDriveIfItsBoundsAreNotNumbers) {
  Gate::Config no_lowest = gate;
  no_lowest.drive_min = not_a_number;
  Gate::Config no_highest = gate;
  no_highest.drive_max = not_a_number;
  for (const Gate::Config& broken : {no_lowest, no_highest}) {
    const Gate::Passed passed = Gate::step(broken, 42.0, 42.0, dt_s);
    EXPECT_EQ(passed.drive, 5.0);
    EXPECT_EQ(passed.limits, limit::not_finite);
  }
}

// Every argument may have any bit pattern.
RC_GTEST_PROP(Gate, PassesOnlyFiniteDrivesInRangeForAnyArguments,
              (std::uint64_t last, std::uint64_t requested, std::uint64_t dt)) {
  const auto any = [](std::uint64_t bits) { return std::bit_cast<double>(bits * 0x9E3779B97F4A7C15u); };
  const Gate::Passed passed = Gate::step(gate, any(last), any(requested), any(dt));
  RC_ASSERT(passed.drive >= gate.drive_min && passed.drive <= gate.drive_max);
}

TEST(Limits, HaveANameEach) {
  EXPECT_EQ(limits_to_string(limit::none), "");
  EXPECT_EQ(limits_to_string(limit::range), "range");
  EXPECT_EQ(limits_to_string(limit::slew), "slew");
  EXPECT_EQ(limits_to_string(limit::not_finite), "not_finite");
  EXPECT_EQ(limits_to_string(limit::model), "model");
  EXPECT_EQ(limits_to_string(limit::not_invertible), "not_invertible");
  EXPECT_EQ(limits_to_string(limit::range | limit::slew), "range+slew");
}

}  // namespace
}  // namespace hystcan::controller::gate_test
