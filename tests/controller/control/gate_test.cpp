#include "controller/control/gate.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

namespace hystcan::controller::gate_test {
namespace {

constexpr Gate::Config gate{.drive_min = -20.0, .drive_max = 120.0, .slew_per_s = 1000.0, .safe_drive = 0.0};
constexpr double dt_s = 1e-3;

TEST(Gate, PassesWhatIsInRangeAndWithinTheSlewLimit) {
  const Gate::Passed passed = Gate::step(gate, 50.0, 50.5, dt_s);
  EXPECT_EQ(passed.drive, 50.5);
  EXPECT_EQ(passed.limits, limit::none);
}

TEST(Gate, LimitsTheSlewAndReportsIt) {
  const Gate::Passed passed = Gate::step(gate, 50.0, 80.0, dt_s);
  EXPECT_DOUBLE_EQ(passed.drive, 51.0);
  EXPECT_EQ(passed.limits, limit::slew);
}

TEST(Gate, LimitsTheRangeAndReportsIt) {
  const Gate::Passed passed = Gate::step(gate, 119.9, 130.0, dt_s);
  EXPECT_EQ(passed.drive, 120.0);
  EXPECT_EQ(passed.limits, limit::range);
}

TEST(Gate, HoldsTheLastDriveWhereTheRequestedDriveIsNotFinite) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    const Gate::Passed passed = Gate::step(gate, 42.0, bad, dt_s);
    EXPECT_EQ(passed.drive, 42.0);
    EXPECT_EQ(passed.limits, limit::not_finite);
  }
}

TEST(Gate, HoldsTheLastDriveWhereTimeGoesBackwards) {
  EXPECT_EQ(Gate::step(gate, 42.0, 50.0, -1.0).drive, 42.0);
}

// The law may request any sequence of drives with any bit patterns.
RC_GTEST_PROP(Gate, PassesOnlyDrivesThatAreFiniteInRangeAndReachable, (std::vector<std::uint64_t> bits)) {
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

TEST(Gate, PassesTheSafeDriveWhereTheLastOneIsUnknown) {
  for (const double last :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const Gate::Passed passed = Gate::step(gate, last, 80.0, dt_s);
    EXPECT_EQ(passed.drive, gate.safe_drive);
    EXPECT_EQ(passed.limits, limit::not_finite);
  }
}

// Every argument may have any bit pattern.
RC_GTEST_PROP(Gate, PassesOnlyFiniteDrivesInRangeWhateverItIsGiven,
              (std::uint64_t last, std::uint64_t requested, std::uint64_t dt)) {
  const auto any = [](std::uint64_t bits) { return std::bit_cast<double>(bits * 0x9E3779B97F4A7C15u); };
  const Gate::Passed passed = Gate::step(gate, any(last), any(requested), any(dt));
  RC_ASSERT(passed.drive >= gate.drive_min && passed.drive <= gate.drive_max);
}

TEST(Limits, AreNamed) {
  EXPECT_EQ(limits_to_string(limit::none), "");
  EXPECT_EQ(limits_to_string(limit::range | limit::slew), "range+slew");
}

}  // namespace
}  // namespace hystcan::controller::gate_test
