#include "twin/amplifier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace hystcan::twin::amplifier_test {
namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;

TEST(Amplifier, FollowsASmallStepAsAFirstOrderLag) {
  const Amplifier::Config config{.slew_per_s = 1e9, .bandwidth_Hz = 1000.0};
  const double tau_s = 1.0 / (two_pi * 1000.0);
  const auto after = Amplifier(config, tau_s)({.output = 0.0, .target = 1.0});
  EXPECT_NEAR(after.output, 1.0 - std::exp(-1.0), 1e-12);
}

TEST(Amplifier, SlewsInAStraightLineThroughALargeStep) {
  const Amplifier::Config config{.slew_per_s = 1000.0, .bandwidth_Hz = 1000.0};
  EXPECT_DOUBLE_EQ(Amplifier(config, 0.01)({.output = 0.0, .target = 100.0}).output, 10.0);
  EXPECT_DOUBLE_EQ(Amplifier(config, 0.01)({.output = 0.0, .target = -100.0}).output, -10.0);
}

}  // namespace
}  // namespace hystcan::twin::amplifier_test
