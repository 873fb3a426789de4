#include "controller/analysis/loop_design.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "tests/controller/analysis/simulated_loop.h"

namespace hystcan::controller::loop_design_test {
namespace {

LoopConfig draw(std::mt19937_64& random) {
  std::uniform_real_distribution<double> part(0.0, 1.0);
  return {.delays = {.command_delay = std::chrono::microseconds(std::lround(500.0 + 2000.0 * part(random))),
                     .amplifier_bandwidth_Hz = 300.0 * std::pow(10.0, part(random)),
                     .resonance_Hz = 30.0 * std::pow(30.0, part(random)),
                     .damping_ratio = 0.01 * std::pow(50.0, part(random))}};
}

LoopConfig stage(double resonance_Hz, double damping_ratio) {
  return {.delays = {.command_delay = std::chrono::milliseconds(1),
                     .amplifier_bandwidth_Hz = 1000.0,
                     .resonance_Hz = resonance_Hz,
                     .damping_ratio = damping_ratio}};
}

LoopConfig with(LoopConfig config, const PiGains& gains) {
  config.pi = gains;
  return config;
}

// The grid steps of the search and the three digits of the gains allow slightly more than the rule.
constexpr double grid_tolerance = 0.03;

TEST(SensitivityRule, HoldsAtEveryCornerForRandomPlants) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 25; ++i) {
    const LoopConfig config = draw(random);
    SCOPED_TRACE(testing::Message() << config.delays.resonance_Hz << " Hz " << config.delays.damping_ratio);
    const PlantUncertainty known = around(config.delays, 0.0);
    const SensitivityRule rule;
    const PiGains gains = largest_gains(config, known, rule);
    EXPECT_GT(gains.ki_per_s, 0.0);
    const Margins worst = judge(with(config, gains), widened(known, rule.resonance_percent)).worst;
    EXPECT_TRUE(worst.stable);
    EXPECT_LE(worst.peak_sensitivity, rule.peak_sensitivity + grid_tolerance);
    EXPECT_GE(worst.gain_margin, rule.peak_sensitivity / (rule.peak_sensitivity - 1.0) - 0.1);
  }
}

TEST(SensitivityRule, HoldsForEveryModeAboveTheStatedOneIfNoneIsShown) {
  const LoopConfig config = stage(1400.0, 0.03);
  PlantUncertainty unshown = around(config.delays, 0.0);
  unshown.resonance_Hz.hi = std::numeric_limits<double>::infinity();
  const SensitivityRule rule;
  const PiGains gains = largest_gains(config, unshown, rule);
  EXPECT_GT(gains.ki_per_s, 0.0);
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) {
    LoopConfig any = config;
    any.delays.resonance_Hz =
        1400.0 * std::pow(10.0, std::uniform_real_distribution<double>(0.0, 1.0)(random));
    const Margins margins = margins_of(LinearLoop(any), gains);
    EXPECT_TRUE(margins.stable) << any.delays.resonance_Hz;
    EXPECT_LE(margins.peak_sensitivity, rule.peak_sensitivity + 2.0 * grid_tolerance)
        << any.delays.resonance_Hz;
  }
}

TEST(Corners, AreAFewForAnyStatedResonance) {
  for (const double resonance_Hz : {1.0, 3e3, 1e12, 1e300}) {
    const LoopConfig config = stage(resonance_Hz, 0.02);
    EXPECT_LE(corners_of(config, around(config.delays, 10.0)).size(), 200u) << resonance_Hz;
  }
}

TEST(UnmeasuredGains, AreAnEighthOfTheStableGains) {
  const LoopConfig config = stage(500.0, 0.02);
  const PlantUncertainty known = around(config.delays, 0.0);
  const PiGains gains = unmeasured_gains(config, known);
  const auto stable = [&](double factor) {
    return margins_of(LinearLoop(config), {.ki_per_s = factor * gains.ki_per_s}).stable;
  };
  EXPECT_TRUE(stable(7.9));
  EXPECT_FALSE(stable(9.0));
}

TEST(SensitivityRule, UsesUpTheSensitivityThatItAllows) {
  for (const double allowed : {1.3, 1.7, 2.0}) {
    const LoopConfig config = stage(220.0, 0.05);
    const SensitivityRule rule{.peak_sensitivity = allowed, .resonance_percent = 5.0};
    const PlantUncertainty known = around(config.delays, 0.0);
    const Margins worst = judge(with(config, largest_gains(config, known, rule)), widened(known, 5.0)).worst;
    EXPECT_NEAR(worst.peak_sensitivity, allowed, grid_tolerance);
  }
}

TEST(SensitivityRule, GivesLessKiForALessCertainPlant) {
  const LoopConfig config = stage(300.0, 0.03);
  const PlantUncertainty known = around(config.delays, 0.0);
  double before = 1e9;
  for (const double percent : {0.0, 5.0, 10.0, 20.0}) {
    const double ki_per_s =
        largest_gains(config, known, SensitivityRule{.resonance_percent = percent}).ki_per_s;
    EXPECT_LE(ki_per_s, before) << percent;
    before = ki_per_s;
  }
}

TEST(Designs, MultiplyTheIntegralOfASoftStageByANotchOrALowPass) {
  const LoopConfig soft = stage(220.0, 0.02);
  const auto settings = designs(soft, around(soft.delays, 0.0), {});
  ASSERT_GT(settings.size(), 3u);
  const LoopConfig& plain = settings.back();
  EXPECT_FALSE(plain.notch || plain.measurement_filter_Hz > 0.0);
  for (const bool notched : {false, true}) {
    const auto best =
        std::ranges::find(settings, notched, [](const auto& of) { return of.notch.has_value(); });
    ASSERT_NE(best, settings.end());
    EXPECT_GT(best->pi.ki_per_s, 5.0 * plain.pi.ki_per_s) << notched;
  }
}

// The best deep notch of this stage allows 1.50 times the integral gain, a shallow one 1.57 times.
TEST(Designs, HaveADeepAndAShallowNotchForADampedMode) {
  const LoopConfig galfenol = stage(300.0, 0.06);
  const auto settings = designs(galfenol, around(galfenol.delays, 0.0), {});
  const double plain_per_s = settings.back().pi.ki_per_s;
  const auto notched = [&](double depth) {
    return std::ranges::find_if(settings,
                                [&](const LoopConfig& of) { return of.notch && of.notch->depth == depth; });
  };
  const auto deep = notched(0.3), shallow = notched(0.6);
  ASSERT_NE(deep, settings.end());
  ASSERT_NE(shallow, settings.end());
  EXPECT_NEAR(deep->pi.ki_per_s / plain_per_s, 1.50, 0.02);
  EXPECT_NEAR(shallow->pi.ki_per_s / plain_per_s, 1.57, 0.02);
}

TEST(Designs, SettleIfTheResonanceIsTenPercentOff) {
  const LoopConfig soft = stage(220.0, 0.02);
  for (const LoopConfig& found : designs(soft, around(soft.delays, 0.0), {}))
    for (const double factor : {0.9, 1.0, 1.1}) {
      LoopConfig actual = found;
      actual.delays.resonance_Hz *= factor;
      EXPECT_LT(simulated::error_after(actual, found.pi, 2000), 1e-3)
          << factor << " ki " << found.pi.ki_per_s;
    }
}

TEST(CautiousRule, HoldsForRandomPlantsAndStaysStableForEveryDelay) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 25; ++i) {
    LoopConfig config = draw(random);
    const PiGains gains = largest_gains(config, around(config.delays, 0.0), CautiousRule{});
    const Margins margins = margins_of(LinearLoop(config), gains);
    EXPECT_TRUE(margins.stable);
    EXPECT_GE(margins.phase_margin_deg, 59.5);  // tolerance for the grid steps
    EXPECT_GE(margins.gain_margin, 1.99);
  }
  LoopConfig soft = stage(120.0, 0.02);
  const PiGains gains = largest_gains(soft, around(soft.delays, 0.0), CautiousRule{});
  for (int delay_us = 0; delay_us <= 2500; delay_us += 100) {
    soft.delays.command_delay = std::chrono::microseconds(delay_us);
    EXPECT_TRUE(margins_of(LinearLoop(soft), gains).stable) << delay_us;
  }
}

// The samples show such a mode on the other side of half the rate, with a rising phase.
TEST(CautiousRule, HoldsIfTheModeMayBeOnBothSidesOfHalfTheRate) {
  LoopConfig config = stage(525.0, 0.0625);
  config.delays.amplifier_bandwidth_Hz = 460.0;
  config.delays.sensor_delay = std::chrono::microseconds(340);
  const PlantUncertainty corners = around(config.delays, 10.0);
  const PiGains gains = largest_gains(config, corners, CautiousRule{});
  const Margins worst = judge(with(config, gains), corners).worst;
  EXPECT_GT(gains.ki_per_s, 0.0);
  EXPECT_TRUE(worst.stable);
  EXPECT_LT(worst.peak_sensitivity, 2.5);
}

TEST(CautiousRule, GivesAFractionOfTheGainsOfTheSensitivityRule) {
  const LoopConfig shipped = stage(500.0, 0.05);
  EXPECT_LT(4.0 * largest_gains(shipped, around(shipped.delays, 0.0), CautiousRule{}).ki_per_s,
            largest_gains(shipped, around(shipped.delays, 0.0), SensitivityRule{}).ki_per_s);
}

TEST(Rules, RequireNumbersWithinTheirRange) {
  const LoopConfig config = stage(500.0, 0.05);
  EXPECT_THROW(largest_gains(config, around(config.delays, 0.0), CautiousRule{.phase_margin_deg = 0.0}),
               std::invalid_argument);
  EXPECT_THROW(largest_gains(config, around(config.delays, 0.0), CautiousRule{.gain_margin = 1.0}),
               std::invalid_argument);
  EXPECT_THROW(largest_gains(config, around(config.delays, 0.0), SensitivityRule{.peak_sensitivity = 1.0}),
               std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::controller::loop_design_test
