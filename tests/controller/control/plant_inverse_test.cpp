#include "controller/control/plant_inverse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "controller/analysis/feed_forward_design.h"
#include "controller/analysis/linear_loop.h"

namespace hystcan::controller::plant_inverse_test {
namespace {

constexpr double cycle_s = 1e-3;

LoopConfig stage(bool interpolated, double delay_us = 1000.0) {
  return {.delays = {.command_delay = std::chrono::nanoseconds(std::llround(1e3 * delay_us)),
                     .amplifier_bandwidth_Hz = 1500.0,
                     .resonance_Hz = 230.0,
                     .damping_ratio = 0.05,
                     .interpolated = interpolated,
                     .sensor_delay = std::chrono::microseconds(170),
                     .sensor_bandwidth_Hz = 900.0},
          .cycle_s = cycle_s};
}

TEST(PlantRecursion, HasTheResponseOfThePlantWithItsNotch) {
  for (const bool interpolated : {false, true})
    for (const double delay_us : {0.0, 300.0, 1000.0, 2710.0}) {
      LoopConfig loop = stage(interpolated, delay_us);
      loop.notch = Notch::Config{.frequency_Hz = 230.0, .depth = 0.1, .width = 0.6};
      const PlantRecursion::Config plant = design_plant_inverse(loop).plant;
      const LinearLoop linear(loop);
      for (const double theta : {0.05, 0.7, 2.9}) {
        PlantRecursion::State state{};
        constexpr int settled = 400;
        double y = 0.0;
        for (int n = 0; n <= settled; ++n) y = PlantRecursion::step(plant, state, std::cos(theta * n));
        const auto expected = linear.plant(theta) * std::polar(1.0, theta * (settled + plant.delay_cycles));
        EXPECT_NEAR(y, expected.real(), 1e-9) << interpolated << " " << delay_us << " us, " << theta;
      }
    }
}

TEST(PlantInverse, FollowsARampWithoutAnError) {
  constexpr double um_per_s = 700.0;
  for (const bool interpolated : {false, true}) {
    const LoopConfig loop = stage(interpolated);
    PlantInverse inverse(design_plant_inverse(loop));
    const double ahead_s = chain_moments(loop.delays, loop.notch, cycle_s).mean_s;
    const auto ramp = [&](double t_s) { return um_per_s * t_s; };
    for (int n = 0; n < 500; ++n) {
      const double t_s = n * cycle_s;
      EXPECT_NEAR(inverse.feed_forward(t_s + ahead_s, cycle_s, ramp), ramp(t_s + ahead_s), 1e-9);
      const double y = inverse.expected(t_s + ahead_s, cycle_s, ramp);
      if (n < 300) continue;  // the state begins at rest
      // The samples of held setpoints are always at the same phase of the staircase.
      EXPECT_NEAR(y, ramp(t_s - loop.delays.sensor_s()), interpolated ? 1e-4 : 0.02 * um_per_s * cycle_s);
    }
  }
}

TEST(PlantInverse, LooksUpTwoValuesInACycle) {
  const LoopConfig loop = stage(false);
  PlantInverse inverse(design_plant_inverse(loop));
  std::size_t looked_up = 0;
  const auto reference = [&](double t_s) {
    ++looked_up;
    return t_s;
  };
  for (int n = 0; n < 10; ++n) {
    if (n == 1) looked_up = 0;
    inverse.feed_forward(n * cycle_s, cycle_s, reference);
    inverse.expected(n * cycle_s, cycle_s, reference);
  }
  EXPECT_EQ(looked_up, 2 * 9);
}

// After a gap, the values in between are not those of the previous cycles.
TEST(PlantInverse, LooksUpAllValuesAgainAfterMissedCycles) {
  const PlantInverse::Config config = design_plant_inverse(stage(false));
  PlantInverse with_a_gap(config), fresh(config);
  const auto reference = [](double t_s) { return std::sin(40.0 * t_s); };
  for (int n = 0; n < 50; ++n) with_a_gap.feed_forward(n * cycle_s, cycle_s, reference);
  EXPECT_DOUBLE_EQ(with_a_gap.feed_forward(60 * cycle_s, cycle_s, reference),
                   fresh.feed_forward(60 * cycle_s, cycle_s, reference));
}

// Otherwise the work of a late cycle would delay the next one too.
TEST(PlantInverse, LooksUpAtMostTwoWindowsAfterALateSync) {
  const PlantInverse::Config config = design_plant_inverse(stage(false));
  PlantInverse late(config), even(config);
  std::size_t looked_up = 0;
  const auto reference = [&](double t_s) {
    ++looked_up;
    return std::sin(40.0 * t_s);
  };
  for (int n = 0; n < 200; ++n) {
    const double at_s = (n + (n == 150 ? 0.45 : 0.0)) * cycle_s;
    const double expected = even.expected(n * cycle_s, cycle_s, reference);
    looked_up = 0;
    late.feed_forward(at_s, cycle_s, reference);
    const double found = late.expected(at_s, cycle_s, reference);
    if (n < 150) continue;
    EXPECT_LE(looked_up, 2 * std::tuple_size_v<FeedForwardWeights>) << n;
    const double way_um = 40.0 * 0.45 * cycle_s;  // during its lateness
    EXPECT_NEAR(found, expected, n == 150 ? 2.0 * way_um : 1.5 * way_um) << n;
  }
}

// A loop that is retuned in motion begins with almost the state of a continuous run.
TEST(PlantInverse, BeginsInMotionAsIfItHadRun) {
  const PlantInverse::Config config = design_plant_inverse(stage(false));
  const auto triangle = [](double t_s) {
    const double phase = 10.0 * t_s - std::floor(10.0 * t_s);
    return 24.0 * (phase < 0.5 ? 2.0 * phase : 2.0 - 2.0 * phase);
  };
  PlantInverse running(config);
  for (int n = 0; n < 1000; ++n) {
    const double expected = running.expected(n * cycle_s, cycle_s, triangle);
    if (n < 700 || n % 13 != 0) continue;
    PlantInverse begun(config);
    EXPECT_NEAR(begun.expected(n * cycle_s, cycle_s, triangle), expected, 0.1) << n;
  }
}

// Two axes at 4 kHz that begin in the same cycle have less than 100 us each.
TEST(PlantInverse, BeginsAtTheRestOfTheReferenceInFewLookUps) {
  const PlantInverse::Config config = design_plant_inverse(stage(false));
  int looked_up = 0;
  const auto ramp = [&](double t_s) {
    ++looked_up;
    return 3.0 + 1000.0 * std::max(t_s, 0.0);
  };
  PlantInverse long_ago(config), at_rest(config);
  at_rest.restart(0.0);
  for (int n = 2; n < 50; ++n) {
    const double expected = long_ago.expected(n * cycle_s, cycle_s, ramp);
    looked_up = 0;
    EXPECT_NEAR(at_rest.expected(n * cycle_s, cycle_s, ramp), expected, 1e-12) << n;
    EXPECT_LE(looked_up, 30) << n;
  }
}

}  // namespace
}  // namespace hystcan::controller::plant_inverse_test
