// An amplifier that moves linearly to its setpoint within a cycle: the closed form, compared with a fine
// numerical integration, the turning points of the plant, and the node at its SYNCs.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>

#include "tests/support/shows.h"
#include "tests/twin/stage.h"
#include "tests/twin/twin_bench.h"

namespace hystcan::twin::interpolation_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

double any_between(double low, double high) {
  return low + (high - low) * 1e-6 * *rc::gen::inRange(0, 1'000'000);
}

DriveLimits any_limits() {
  DriveLimits limits{.omega = any_between(500.0, 10'000.0), .slew_per_s = any_between(100.0, 20'000.0)};
  if (*rc::gen::arbitrary<bool>()) {
    limits.load_rate_per_s = any_between(50.0, 12'000.0);
    limits.load_limit = any_between(6.0, 30.0);
  }
  return limits;
}

Amplifier::State any_motion() {
  return {.output = any_between(-5.0, 5.0),
          .target = any_between(-5.0, 5.0),
          .rate_per_s = any_between(-15'000.0, 15'000.0)};
}

/// v' by the equations of Amplifier, without a closed form.
double rate_of(const DriveLimits& limits, double output, double target) {
  double most = limits.slew_per_s, least = -limits.slew_per_s;
  if (std::isfinite(limits.load_limit)) {
    most = std::min(most, limits.load_rate_per_s * (limits.load_limit - output));
    least = std::max(least, limits.load_rate_per_s * (-limits.load_limit - output));
  }
  return std::clamp(limits.omega * (target - output), least, most);
}

/// Integrates by the midpoint rule.
double integrated(const DriveLimits& limits, const Amplifier::State& start, double time_s) {
  constexpr int steps = 20'000;
  const double dt_s = time_s / steps;
  double v = start.output;
  for (int i = 0; i < steps; ++i) {
    const double r = start.target + start.rate_per_s * dt_s * i;
    const double middle = v + 0.5 * dt_s * rate_of(limits, v, r);
    v += dt_s * rate_of(limits, middle, r + 0.5 * dt_s * start.rate_per_s);
  }
  return v;
}

TEST(MovingTarget, IsFollowedAsByAFineIntegration) {
  EXPECT_TRUE(rc::check("integration", [] {
    const DriveLimits limits = any_limits();
    const Amplifier::State start = any_motion();
    const double time_s = any_between(1e-5, 2e-3);
    RC_ASSERT(std::abs(start.output_after(limits, time_s) - integrated(limits, start, time_s)) < 1e-5);
  }));
}

TEST(MovingTarget, IsFollowedToTheSameOutputInOneStepAndInTwo) {
  EXPECT_TRUE(rc::check("parts", [] {
    const DriveLimits limits = any_limits();
    const Amplifier::State start = any_motion();
    const double first_s = any_between(1e-6, 2e-3), second_s = any_between(1e-6, 2e-3);
    Amplifier::State half = start;
    half.output = start.output_after(limits, first_s);
    half.target += start.rate_per_s * first_s;
    RC_ASSERT(std::abs(half.output_after(limits, second_s) - start.output_after(limits, first_s + second_s)) <
              1e-10);
  }));
}

TEST(MovingTarget, LetsTheOutputTurnOnceAtTheTimeThatItStates) {
  EXPECT_TRUE(rc::check("turn", [] {
    const DriveLimits limits = any_limits();
    const Amplifier::State start = any_motion();
    const double time_s = any_between(1e-4, 4e-3);
    const double turn_s = start.turns_after_s(limits, time_s);
    double before = start.output;
    for (int i = 1; i <= 400; ++i) {
      const double at_s = time_s * i / 400, began_s = time_s * (i - 1) / 400;
      const double v = start.output_after(limits, at_s);
      const double way = std::copysign(1.0, start.rate_per_s) * (v - before);
      before = v;
      if (at_s <= turn_s && std::isfinite(turn_s)) RC_ASSERT(way < 1e-12);
      if (began_s >= turn_s) RC_ASSERT(way > -1e-12);
    }
    if (std::isfinite(turn_s)) {
      const double target = start.target + start.rate_per_s * turn_s;
      RC_ASSERT(std::abs(start.output_after(limits, turn_s) - target) < 1e-9);
    }
  }));
}

TEST(MovingTarget, IsFollowedByTheAmplifiersStepWithinTheLag) {
  const Amplifier::Config config{.slew_per_s = 1e6, .bandwidth_Hz = 1000.0};
  const Amplifier::State start{.output = 5.0, .target = 6.0, .rate_per_s = -2000.0};
  const Amplifier::State after = Amplifier(config, 7e-4)(start);
  EXPECT_NEAR(after.output,
              Amplifier::State({.output = 5.0, .target = 6.0, .rate_per_s = -2000.0})
                  .output_after(Amplifier::limits(config), 7e-4),
              1e-12);
  EXPECT_DOUBLE_EQ(after.target, 6.0 - 2000.0 * 7e-4);
}

// The output still rises for some 100 us after the turn of the target. A plant with sub-steps of 1 ms that
// turned only at their ends would store another memory.
TEST(PlantWithAMovingTarget, MissesNoTurningPointOfItsOutput) {
  const auto stage = [](can::Duration substep) {
    Plant::Config config = piezo_stage();
    config.substep = substep;
    return config;
  };
  Plant coarse(stage(milliseconds(1)), can::Time{}), fine(stage(microseconds(1)), can::Time{});
  for (int i = 1; i <= 100; ++i) {
    const double drive = 50.0 + 40.0 * std::sin(2.3 * i);
    for (Plant* plant : {&coarse, &fine}) {
      plant->move_target(drive, microseconds(970));
      plant->advance_to(can::Time{} + i * microseconds(970));
    }
    ASSERT_NEAR(coarse.drive(), fine.drive(), 1e-9) << i;
    ASSERT_NEAR(coarse.hysteresis_um(), fine.hysteresis_um(), 1e-7) << i;
  }
}

TEST(PlantWithAMovingTarget, EndsAtTheTargetAndHoldsIt) {
  Plant plant(linear_stage(), can::Time{});
  plant.move_target(40.0, milliseconds(1));
  plant.advance_to(can::Time{} + milliseconds(10));
  EXPECT_NEAR(plant.drive(), 40.0, 1e-12);
  plant.advance_to(can::Time{} + std::chrono::hours(1));
  EXPECT_DOUBLE_EQ(plant.drive(), 40.0);
}

TEST(PlantWithAMovingTarget, DropsTheMotionWhenATargetIsSet) {
  Plant plant(linear_stage(), can::Time{});
  plant.move_target(100.0, milliseconds(1));
  plant.advance_to(can::Time{} + microseconds(500));
  plant.set_target(10.0);
  plant.advance_to(can::Time{} + milliseconds(10));
  EXPECT_NEAR(plant.drive(), 10.0, 1e-9);
}

/// An axis whose output follows its target at once and that interpolates at 1 kHz.
Config interpolating() {
  Config config = one_axis();
  config.cycle = milliseconds(1);
  config.axes.front().axis.interpolate = true;
  config.axes.front().axis.plant.amplifier.bandwidth_Hz = 1e6;
  config.axes.front().axis.plant.amplifier.slew_per_s = 1e9;
  return config;
}

class InterpolatingAmplifier : public testing::Test {
 protected:
  void SetUp() override {
    bench_.start_nodes();
    bench_.drive(0.0, 5);
  }
  double output() {
    plant().advance_to(bench_.clock_.now());
    return plant().drive();
  }
  Plant& plant() { return bench_.twin_.axes().front()->plant; }
  void next_cycle(double setpoint) { bench_.drive(setpoint, 1); }

  TwinBench bench_{interpolating()};
};

// 0.6 V: the duration of the SYNC frame.
TEST_F(InterpolatingAmplifier, MovesStraightToTheSetpointFromSyncToSync) {
  shows("S-085");
  next_cycle(10.0);
  bench_.sync();
  for (int quarter = 1; quarter <= 4; ++quarter) {
    bench_.run(microseconds(250));
    EXPECT_NEAR(output(), 2.5 * quarter, 0.6) << quarter;
  }
  bench_.run(microseconds(100));
  EXPECT_NEAR(output(), 10.0, 1e-9);
}

TEST_F(InterpolatingAmplifier, HoldsTheSetpointWhenACommandIsLost) {
  shows("S-087");
  next_cycle(10.0);
  for (int i = 0; i < 3; ++i) bench_.cycle();
  EXPECT_NEAR(output(), 10.0, 1e-9);
}

TEST_F(InterpolatingAmplifier, HoldsTheSetpointWhenASyncIsLost) {
  shows("S-087");
  next_cycle(10.0);
  bench_.sync();
  bench_.command(20.0, true);
  bench_.run(milliseconds(3));
  EXPECT_NEAR(output(), 10.0, 1e-9);
}

// The motion to 10 V is interrupted at about 4.5 V; the motion to 20 V begins there.
TEST_F(InterpolatingAmplifier, ContinuesFromItsOutputAtAnEarlySync) {
  shows("S-086");
  next_cycle(10.0);
  bench_.sync();
  bench_.command(20.0, true);
  bench_.run(microseconds(500));
  const double before = output();
  EXPECT_NEAR(before, 4.5, 0.6);
  bench_.sync();
  bench_.run(microseconds(100));
  EXPECT_NEAR(output() - before, 1.0, 0.6);
  bench_.run(milliseconds(1));
  EXPECT_NEAR(output(), 20.0, 1e-9);
}

TEST_F(InterpolatingAmplifier, JumpsToTheSafeDriveWhenItsWatchdogTrips) {
  shows("S-088");
  bench_.drive(50.0, 5);
  bench_.run(milliseconds(20));
  EXPECT_NEAR(output(), 0.0, 1e-9);
}

}  // namespace
}  // namespace hystcan::twin::interpolation_test
