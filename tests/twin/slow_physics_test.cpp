// Slow motion and motion from another axis: creep, temperature, cross-coupling.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/twin/stage.h"

namespace hystcan::twin::slow_physics_test {
namespace {

using std::chrono::milliseconds;

constexpr LogarithmicCreep slow{.per_decade = 0.015, .from_s = 0.1, .to_s = 100.0};

Plant::Config creeping_stage() {
  Plant::Config config = linear_stage();
  config.creep = slow;
  return config;
}

TEST(Creep, DoesNotBeginBeforeAnythingMoves) {
  Plant plant(creeping_stage(), can::Time{});
  plant.advance_to(can::Time{} + std::chrono::hours(72));
  EXPECT_NEAR(plant.position_um(), 0.0, 1e-14);
}

// A held step of 15 um:
//   x(t) = 15 um (1 + sum w_i (1 - e^{-a_i t}))
// The amplifier's lag of 0.13 ms reduces it by less than 1 nm: the slope at the start is 15 um * 0.3 / s.
TEST(Creep, FollowsItsOperatorsAfterAStep) {
  const model::Creep::Operators operators = model::logarithmic_creep(slow.per_decade, slow.from_s, slow.to_s);
  Plant plant(creeping_stage(), can::Time{});
  plant.set_target(50.0);
  for (const double time_s : {0.3, 1.0, 3.0, 10.0, 30.0}) {
    plant.advance_to(at_s(time_s));
    double crept = 0.0;
    for (const auto& one : operators) crept += one.weight * -std::expm1(-one.rate_per_s * time_s);
    EXPECT_NEAR(plant.position_um(), 15.0 * (1.0 + crept), 1e-3) << time_s << " s";
  }
}

/// The creep of a model file: h is immediate except for n w of it, which follows with the lags.
Plant::Config stage_with_creeping_model() {
  Plant::Config config = linear_stage();
  config.hysteresis_creep = {.per_decade = 0.02, .from_s = 0.01, .to_s = 1.0};
  return config;
}

TEST(CreepOfTheModel, DoesNotBeginBeforeAnythingMoves) {
  Plant plant(stage_with_creeping_model(), can::Time{});
  plant.advance_to(can::Time{} + std::chrono::hours(72));
  EXPECT_EQ(plant.position_um(), 0.0);
}

// The amplifier's lag of 0.13 ms reduces it by less than 0.2 nm: after 0.1 s the slope is 1.3 um/s.
TEST(CreepOfTheModel, FollowsItsLagsAfterAStep) {
  const model::OutputCreep creep(stage_with_creeping_model().hysteresis_creep);
  Plant plant(stage_with_creeping_model(), can::Time{});
  plant.set_target(50.0);
  model::OutputCreep::State state = creep.settled(0.0);
  double before_s = 0.0;
  for (const double time_s : {0.1, 0.3, 1.0, 3.0}) {
    creep.advance(state, 15.0, time_s - before_s);
    before_s = time_s;
    plant.advance_to(at_s(time_s));
    EXPECT_NEAR(plant.position_um(), creep.output(state, 15.0), 2e-4) << time_s << " s";
  }
}

TEST(Creep, IsAbsentForZeroPerDecade) {
  Plant::Config config = piezo_stage();
  Plant plain(config, can::Time{});
  config.creep = {.per_decade = 0.0};
  Plant crept(config, can::Time{});
  for (Plant* plant : {&plain, &crept}) {
    plant->set_target(50.0);
    plant->advance_to(at_s(0.1));
  }
  EXPECT_EQ(plain.position_um(), crept.position_um());
}

/// Rests for half a day at a temperature with a period of a day. The position is read every 0.7 s during the
/// first minutes, or not at all.
double half_a_day_later_um(bool watched) {
  Plant::Config config = creeping_stage();
  config.temperature =
      Temperature{.swing_K = 2.0, .period_s = 86'400.0, .expansion_um_per_K = 0.15, .gain_per_K = 1e-3};
  Plant plant(config, can::Time{});
  plant.set_target(50.0);
  for (int i = 1; watched && i < 500; ++i) plant.advance_to(can::Time{} + i * milliseconds(700));
  plant.advance_to(can::Time{} + std::chrono::hours(12) + milliseconds(3));
  plant.set_target(20.0);
  plant.advance_to(can::Time{} + std::chrono::hours(12) + milliseconds(4));
  return plant.position_um();
}

// 9e8 single sub-steps would take minutes, but a twin must answer its first SYNC in time.
TEST(SlowPhysics, NeedsLittleComputingTimeAtRest) {
  EXPECT_EQ(half_a_day_later_um(true), half_a_day_later_um(false)) << "to the bit";
}

// The slowest operator has settled except for e^{-259200 s / 10^4 s}. The sine of the day is zero, with a
// slope of 22 pm/s.
TEST(SlowPhysics, IsExactAfterALongTime) {
  const model::Creep::Operators operators = model::logarithmic_creep(slow.per_decade, slow.from_s, slow.to_s);
  double whole = 0.0;
  for (const auto& one : operators) whole += one.weight;
  Plant::Config config = creeping_stage();
  config.temperature =
      Temperature{.swing_K = 2.0, .period_s = 86'400.0, .expansion_um_per_K = 0.15, .gain_per_K = 1e-3};
  Plant plant(config, can::Time{});
  plant.set_target(50.0);
  plant.advance_to(can::Time{} + std::chrono::hours(72));
  EXPECT_NEAR(plant.position_um(), 15.0 * (1.0 + whole), 1e-8);
}

TEST(Temperature, MovesTheStageAndItsStrokeWithTheAmbientSine) {
  Plant::Config config = linear_stage();
  config.temperature =
      Temperature{.swing_K = 2.0, .period_s = 40.0, .expansion_um_per_K = 0.15, .gain_per_K = -1e-3};
  Plant plant(config, can::Time{});
  const auto settled_at = [&](double time_s) {
    plant.advance_to(at_s(time_s));
    return plant.position_um();
  };
  // The mode lags by 2 zeta / omega = 32 us: 1.5 pm of 0.047 um/s.
  EXPECT_NEAR(settled_at(10.0), 0.3, 1e-9) << "a quarter: 2 K warmer, no travel yet";
  plant.set_target(50.0);
  EXPECT_NEAR(settled_at(20.0), 15.0, 1e-5) << "half: as at the start, but cooling at 0.3 K/s";
  EXPECT_NEAR(settled_at(30.0), 15.0 * (1.0 + 2e-3) - 0.3, 1e-9) << "three quarters: 2 K colder";
}

TEST(Coupling, AddsTheMotionOfTheOtherAxisFromItsStart) {
  Plant x(piezo_stage(), can::Time{}), y(piezo_stage(), can::Time{});
  x.couple(y, 0.02);
  y.couple(x, -0.05);  // both ways: each adds the other's own position, without the coupling error in it
  x.set_target(60.0);
  x.advance_to(can::Time{} + milliseconds(500));
  y.advance_to(can::Time{} + milliseconds(500));
  const double x_um = x.position_um();
  EXPECT_NEAR(x_um, support::piezo_model().ascending.value(60.0), 1e-9);
  EXPECT_NEAR(y.position_um(), -0.05 * x_um, 1e-12);
  y.set_target(20.0);
  x.advance_to(can::Time{} + milliseconds(1000));
  const double y_um = support::piezo_model().ascending.value(20.0);
  EXPECT_NEAR(x.position_um(), x_um + 0.02 * y_um, 1e-9) << "reading x reads y too";
  EXPECT_NEAR(x.crosstalk_um(), 0.02 * y_um, 1e-9);
}

}  // namespace
}  // namespace hystcan::twin::slow_physics_test
