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

TEST(Amplifier, HasTheSameOutputAfterOneStepAndAfterMany) {
  const Amplifier::Config config{.slew_per_s = 2000.0, .bandwidth_Hz = 200.0};
  const Amplifier::State start{.output = 5.0, .target = 30.0};
  for (const double total_s : {0.001, 0.012, 0.013, 0.05}) {
    const auto once = Amplifier(config, total_s)(start);
    Amplifier::State many = start;
    const Amplifier small(config, total_s / 1000.0);
    for (int i = 0; i < 1000; ++i) many = small(many);
    EXPECT_NEAR(once.output, many.output, 1e-9) << total_s << " s";
  }
}

TEST(Amplifier, NeverOvershoots) {
  const Amplifier::Config config{.slew_per_s = 500.0, .bandwidth_Hz = 50.0};
  const Amplifier step(config, 0.0007);
  Amplifier::State state{.output = 0.0, .target = 10.0};
  for (int i = 0; i < 1000; ++i) {
    const double before = state.output;
    state = step(state);
    ASSERT_GE(state.output, before);
    ASSERT_LE(state.output, 10.0);
  }
  EXPECT_NEAR(state.output, 10.0, 1e-12);
}

}  // namespace
}  // namespace hystcan::twin::amplifier_test
