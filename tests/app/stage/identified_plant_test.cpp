// Records of known chains: the actual chain is found, not an equivalent one with a pure delay.
#include "app/stage/identified_plant.h"

#include <gtest/gtest.h>

#include <random>

#include "controller/analysis/linear_loop.h"

namespace hystcan::app::identified_plant_test {
namespace {

constexpr double cycle_s = 1e-3;

/// Steps of 1 around 0, with little noise.
identification::Dataset record_of(const controller::Delays& chain) {
  const controller::PlantRecursion::Config plant = controller::held_plant(chain, cycle_s);
  auto state = controller::PlantRecursion::at_rest(-1.0);
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 1e-4);
  const auto drive = [](int n) { return n < 0 || n / 300 % 2 == 0 ? -1.0 : 1.0; };
  identification::Dataset record;
  for (int n = 0; n < 2400; ++n) {
    record.time_s.push_back(n * cycle_s);
    record.input.push_back(drive(n));
    record.output.push_back(controller::PlantRecursion::step(plant, state, drive(n - plant.delay_cycles)) +
                            noise(random));
  }
  return record;
}

void expect_found(const controller::Delays& chain) {
  controller::Delays stated = chain;
  stated.resonance_Hz = 1.1 * chain.resonance_Hz;
  stated.damping_ratio = 0.1;
  stated.amplifier_bandwidth_Hz = 800.0;
  const identification::Dataset record = record_of(chain);
  const controller::Delays found = identified_plant(record, stated).delays;
  EXPECT_NEAR(found.resonance_Hz, chain.resonance_Hz, 0.002 * chain.resonance_Hz);
  EXPECT_NEAR(found.damping_ratio, chain.damping_ratio, 0.03 * chain.damping_ratio);
  EXPECT_NEAR(found.amplifier_bandwidth_Hz, chain.amplifier_bandwidth_Hz,
              0.05 * chain.amplifier_bandwidth_Hz);
}

TEST(IdentifiedPlant, HasTheLagOfTheAmplifier) {
  expect_found({.amplifier_bandwidth_Hz = 1000.0, .resonance_Hz = 300.0, .damping_ratio = 0.06});
  expect_found({.amplifier_bandwidth_Hz = 1500.0, .resonance_Hz = 410.0, .damping_ratio = 0.03});
}

TEST(IdentifiedPlant, IncludesTheInterpolationOfTheAmplifierOnce) {
  expect_found({.amplifier_bandwidth_Hz = 1200.0,
                .resonance_Hz = 260.0,
                .damping_ratio = 0.025,
                .interpolated = true});
}

TEST(IdentifiedPlant, KeepsTheStatedDelayOfTheSensor) {
  expect_found({.amplifier_bandwidth_Hz = 900.0,
                .resonance_Hz = 220.0,
                .damping_ratio = 0.04,
                .sensor_delay = std::chrono::microseconds(300),
                .sensor_bandwidth_Hz = 2000.0});
}

}  // namespace
TEST(IdentifiedPlant, DistinguishesAPureDelayFromALag) {
  const controller::Delays chain{.amplifier_bandwidth_Hz = 600.0,
                                 .resonance_Hz = 310.0,
                                 .damping_ratio = 0.03,
                                 .sensor_delay = std::chrono::microseconds(300)};
  controller::Delays stated = chain;
  stated.sensor_delay = {};
  const IdentifiedPlant found = identified_plant(record_of(chain), stated);
  EXPECT_NEAR(found.pure_s, 300e-6, 10e-6);
  EXPECT_NEAR(found.delays.amplifier_bandwidth_Hz, 600.0, 20.0);
  ASSERT_TRUE(found.mode);
  EXPECT_LT(found.mode->damping_ratio.lo, 0.03);
  EXPECT_GT(found.mode->damping_ratio.hi, 0.03);
}

TEST(IdentifiedPlant, UsesTheStatedModeIfTheSamplesCannotShowIt) {
  const controller::Delays chain{
      .amplifier_bandwidth_Hz = 900.0, .resonance_Hz = 1730.0, .damping_ratio = 0.03};
  controller::Delays stated = chain;
  stated.resonance_Hz = 1650.0;
  const IdentifiedPlant found = identified_plant(record_of(chain), stated);
  EXPECT_FALSE(found.mode);
  EXPECT_FALSE(found.not_shown.empty());
  EXPECT_NEAR(found.delays.amplifier_bandwidth_Hz, 900.0, 45.0);
  EXPECT_EQ(found.uncertainty.resonance_Hz.lo, stated.resonance_Hz);
  EXPECT_FALSE(found.uncertainty.shows_mode());
}

}  // namespace hystcan::app::identified_plant_test
