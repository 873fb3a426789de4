#include "controller/analysis/linear_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "tests/controller/analysis/simulated_loop.h"

namespace hystcan::controller::margins_test {
namespace {

constexpr double pi = std::numbers::pi;

// This mode settles within a cycle, so that the plant is z^-1 for a delay within the cycle. The loop is
//   L = ki T z / (z - 1) z^-c z^-1,   |L| = ki T / (2 sin(theta / 2)),   arg L = -90 deg - (c + 1/2) theta
LoopConfig integrator(int cycles) {
  constexpr double cycle_s = 0.01;
  return {.delays = {.command_delay = std::chrono::milliseconds(10 * cycles),
                     .amplifier_bandwidth_Hz = 1e6,
                     .resonance_Hz = 2000.0,
                     .damping_ratio = 0.7},
          .cycle_s = cycle_s};
}

TEST(Margins, AreExactForAnIntegratorWithDelay) {
  for (const int cycles : {0, 1, 3})
    for (const double ki_per_cycle : {0.05, 0.2, 0.35}) {
      const LoopConfig config = integrator(cycles);
      const Margins margins = margins_of(LinearLoop(config), {.ki_per_s = ki_per_cycle / config.cycle_s});
      const double crossover = 2.0 * std::asin(ki_per_cycle / 2.0);
      const double at_180 = pi / (2.0 * cycles + 1.0);
      EXPECT_NEAR(margins.crossover_Hz, crossover / (2.0 * pi * config.cycle_s), 1e-9);
      if (margins.stable) {
        EXPECT_NEAR(margins.phase_margin_deg, 90.0 - (cycles + 0.5) * crossover * 180.0 / pi, 1e-9);
      }
      EXPECT_NEAR(margins.gain_margin, 2.0 * std::sin(at_180 / 2.0) / ki_per_cycle, 1e-9);
      EXPECT_EQ(margins.stable, margins.gain_margin > 1.0);
    }
}

TEST(Margins, ShowTheLimitOfStability) {
  const LinearLoop loop(integrator(1));  // ultimate ki T = 2 sin(pi / 6) = 1
  EXPECT_TRUE(margins_of(loop, {.ki_per_s = 99.9}).stable);
  EXPECT_FALSE(margins_of(loop, {.ki_per_s = 100.1}).stable);
  EXPECT_FALSE(margins_of(loop, {.ki_per_s = 1e300}).stable);
}

TEST(Margins, GiveTheLargestStableKi) {
  const PiGains stable = largest_stable_gains(LinearLoop(integrator(1)), {.ki_per_s = 1e6});
  EXPECT_NEAR(stable.ki_per_s, 99.0, 1.0) << "two digits, rounded down";
}

TEST(Margins, GiveTheLargestKpIfNoKiIsStable) {
  const LinearLoop loop(integrator(1));  // L = kp z^-2 is stable below 1
  const PiGains stable = largest_stable_gains(loop, {.kp = 50.0, .ki_per_s = 10.0});
  EXPECT_EQ(stable.ki_per_s, 0.0);
  EXPECT_NEAR(stable.kp, 0.99, 0.01);
}

TEST(Margins, AreTrivialWithoutGains) {
  const Margins margins = margins_of(LinearLoop(integrator(1)), {});
  EXPECT_TRUE(margins.stable);
  EXPECT_EQ(margins.peak_sensitivity, 1.0);
  EXPECT_EQ(margins.bandwidth_Hz, 0.0);
}

// With all parts, the analysed loop equals the loop of the law (controller/control/law.h) in every cycle.
TEST(Margins, AgreeWithTheLawInTheTimeDomain) {
  for (const LoopConfig& config : simulated::loops()) {
    SCOPED_TRACE(simulated::name_of(config));
    const LinearLoop loop(config);
    const PiGains gains{.kp = 0.05, .ki_per_s = 50.0};
    const double limit = margins_of(loop, gains).gain_margin;
    ASSERT_TRUE(std::isfinite(limit));
    for (const double factor : {0.97, 1.03}) {
      const PiGains scaled{.kp = factor * limit * gains.kp, .ki_per_s = factor * limit * gains.ki_per_s};
      EXPECT_EQ(margins_of(loop, scaled).stable, factor < 1.0);
      const bool settles = simulated::error_after(config, scaled, 4000) < 0.1;
      EXPECT_EQ(settles, factor < 1.0) << factor;
    }
  }
}

TEST(Margins, RequireValidGains) {
  const LinearLoop loop(integrator(1));
  EXPECT_THROW(margins_of(loop, {.kp = -0.1, .ki_per_s = 10.0}), std::invalid_argument);
  EXPECT_THROW(margins_of(loop, {.ki_per_s = std::numeric_limits<double>::infinity()}),
               std::invalid_argument);
  EXPECT_THROW(margins_of(loop, {.kp = std::nan("")}), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::controller::margins_test
