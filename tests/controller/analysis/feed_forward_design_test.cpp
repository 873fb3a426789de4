// The feed-forward, compared with the chain between the samples.
#include "controller/analysis/feed_forward_design.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "model/second_order.h"

namespace hystcan::controller::feed_forward_design_test {
namespace {

constexpr double cycle_s = 1e-3;
constexpr double frequency_Hz = 10.0;

LoopConfig stage(double resonance_Hz, double damping_ratio, bool interpolated) {
  return {.delays = {.command_delay = std::chrono::milliseconds(1),
                     .amplifier_bandwidth_Hz = 1500.0,
                     .resonance_Hz = resonance_Hz,
                     .damping_ratio = damping_ratio,
                     .interpolated = interpolated},
          .cycle_s = cycle_s};
}

Triangle triangle() { return {.low_um = 0.0, .high_um = 24.0, .frequency_Hz = frequency_Hz, .cycles = 1e3}; }

/// RMS error between the samples, um, of the stage driven by the weighted reference, over its 20th period.
double true_error_um(const LoopConfig& loop, const FeedForwardWeights& weights) {
  constexpr int fine = 100;
  constexpr double dt_s = cycle_s / fine;
  const double ahead_s = chain_moments(loop.delays, loop.notch, cycle_s).mean_s;
  const double delay_s = std::chrono::duration<double>(loop.delays.command_delay).count();
  const Shape shape = triangle();
  const auto setpoint = [&](int cycle) {
    double sum = 0.0;
    for (int k = -feed_forward_reach; k <= feed_forward_reach; ++k)
      sum += weights[static_cast<std::size_t>(k + feed_forward_reach)] *
             value_um(shape, (cycle + k) * cycle_s + ahead_s);
    return sum;
  };
  const double lag = 1.0 - std::exp(-2.0 * std::numbers::pi * loop.delays.amplifier_bandwidth_Hz * dt_s);
  const model::SecondOrder mode({loop.delays.resonance_Hz, loop.delays.damping_ratio}, dt_s);
  model::SecondOrder::State state;
  double driven = 0.0, sum = 0.0;
  int counted = 0;
  for (int cycle = 0; cycle < 2000; ++cycle) {
    const double before = setpoint(cycle - 1), now = setpoint(cycle);
    for (int i = 0; i < fine; ++i) {
      const double part = (i + 0.5) / fine;
      const double driven_before = driven;
      driven += lag * ((loop.delays.interpolated ? before + (now - before) * part : now) - driven);
      state = mode(state, driven_before, driven);
      if (cycle < 1900) continue;
      const double error_um =
          value_um(shape, (cycle + (i + 1.0) / fine) * cycle_s + delay_s) - state.position;
      sum += error_um * error_um;
      ++counted;
    }
  }
  return std::sqrt(sum / counted);
}

double floor_um(const LoopConfig& loop) {
  return tracking_floor_um(loop.delays, cycle_s, triangle()).value();
}

TEST(PlantInverseDesign, LeavesHardlyMoreThanTheFloorOfATriangle) {
  for (const bool interpolated : {false, true}) {
    const LoopConfig loop = stage(500.0, 0.05, interpolated);
    const double error_um = true_error_um(loop, design_plant_inverse(loop).feed_forward);
    EXPECT_LT(error_um, 1.3 * floor_um(loop)) << interpolated;
    EXPECT_GT(error_um, 0.98 * floor_um(loop)) << interpolated;
  }
}

TEST(PlantInverseDesign, DoesNotRingALightlyDampedMode) {
  const LoopConfig loop = stage(220.0, 0.02, false);
  FeedForwardWeights mean_delay{};
  mean_delay[feed_forward_reach] = 1.0;
  const double inverse_um = true_error_um(loop, design_plant_inverse(loop).feed_forward);
  EXPECT_LT(inverse_um, true_error_um(loop, mean_delay) / 10.0);
  EXPECT_LT(inverse_um, 1.3 * floor_um(loop));
}

TEST(PlantInverseDesign, HasUnitGainAndNoDelay) {
  for (const double resonance_Hz : {30.0, 220.0, 499.0, 3000.0}) {
    const FeedForwardWeights weights = design_plant_inverse(stage(resonance_Hz, 0.05, false)).feed_forward;
    double sum = 0.0, mean = 0.0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      sum += weights[i];
      mean += weights[i] * (static_cast<double>(i) - feed_forward_reach);
    }
    EXPECT_NEAR(sum, 1.0, 1e-9) << resonance_Hz;
    EXPECT_NEAR(mean, 0.0, 1e-9) << resonance_Hz;
  }
}

TEST(PlantInversePlan, IsMadeOnlyIfConfigured) {
  AxisConfig axis;
  axis.delays = stage(500.0, 0.05, false).delays;
  plan_feed_forward(axis, 1000.0);
  EXPECT_FALSE(axis.plant_inverse);
  axis.delays.plant_inverse = true;
  plan_feed_forward(axis, 1000.0);
  EXPECT_TRUE(axis.plant_inverse);
}

}  // namespace
}  // namespace hystcan::controller::feed_forward_design_test
