// The inverse with the creep of the model, on an actuator with exactly this hysteresis and creep.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "controller/control/law.h"
#include "tests/controller/control/ideal_stage.h"
#include "tests/support/count_allocations.h"
#include "tests/support/piezo.h"
#include "tests/support/wiped.h"

namespace hystcan::controller::creep_compensation_test {
namespace {

constexpr double dt_s = 1e-3;
constexpr model::OutputCreep::Config three_percent{.per_decade = 0.03, .from_s = 0.01, .to_s = 10.0};

ControlLaw::Config config(Structure structure,
                          std::optional<model::OutputCreep::Config> creep = three_percent,
                          PiGains pi = {.kp = 0.3, .ki_per_s = 100.0}) {
  return {.structure = structure, .model = support::piezo_model(), .creep = creep, .pi = pi};
}

/// An actuator that creeps by 3 % per decade, and its law. Both have rested at the lower threshold.
class Loop {
 public:
  explicit Loop(const ControlLaw::Config& config) : law(config) {
    support::restart_at_lower_threshold(law, position_um());
  }

  double position_um() const { return creep_.output(creep_state_, memory_.output); }

  /// Advances by one cycle after the drive was held for dt_s. `drive_max`: limit of the gate.
  ControlLaw::Demand cycle(double reference_um, double drive_max = 100.0) {
    creep_.advance(creep_state_, memory_.output, dt_s);
    law.elapse(dt_s);
    const ControlLaw::Demand demand = law.propose({.reference_um = reference_um,
                                                   .previewed_um = reference_um,
                                                   .position_um = position_um(),
                                                   .dt_s = dt_s,
                                                   .cycle_s = dt_s});
    drive = std::min(demand.drive, drive_max);
    hysteresis_.advance(memory_, drive);
    law.commit(drive);
    return demand;
  }
  /// Returns the drive of a cycle without elapsed time and without a new sample.
  double repeated(double reference_um) {
    return law
        .propose({.reference_um = reference_um,
                  .previewed_um = reference_um,
                  .position_um = std::nullopt,
                  .dt_s = 0.0,
                  .cycle_s = dt_s})
        .drive;
  }

  ControlLaw law;
  double drive = 0.0;

 private:
  model::Hysteresis hysteresis_{support::piezo_model()};
  model::HysteresisState memory_ = hysteresis_.at_lower_threshold();
  model::OutputCreep creep_{three_percent};
  model::OutputCreep::State creep_state_ = creep_.settled(memory_.output);
};

/// Returns the motion of the position in 10 s after a step of 80 % of the stroke.
double drift_um(const ControlLaw::Config& config) {
  Loop loop(config);
  loop.cycle(27.0);
  double lowest_um = loop.position_um(), highest_um = lowest_um;
  for (int i = 0; i < 10'000; ++i) {
    loop.cycle(27.0);
    lowest_um = std::min(lowest_um, loop.position_um());
    highest_um = std::max(highest_um, loop.position_um());
  }
  return highest_um - lowest_um;
}

TEST(CreepCompensation, HoldsAStepWithinANanometreWithoutFeedback) {
  EXPECT_LT(drift_um(config(Structure::inverse)), 1e-3);
}

// Three decades of 3 % of 25.5 um are 2.3 um.
TEST(CreepCompensation, IsNecessaryToHoldAStep) {
  EXPECT_GT(drift_um(config(Structure::inverse, std::nullopt)), 2.0);
}

// Two exact inverses differ only by rounding.
TEST(CreepCompensation, PredictsThePositionForAnyReference) {
  Loop loop(config(Structure::inverse));
  for (int i = 0; i < 5000; ++i) {
    loop.cycle(15.0 + 10.0 * std::sin(0.003 * i) + 1.5 * std::sin(0.1 * i));
    ASSERT_NEAR(loop.law.predicted_um(), loop.position_um(), 1e-9) << i;
  }
}

class CreepingStructure : public testing::TestWithParam<Structure> {};
INSTANTIATE_TEST_SUITE_P(All, CreepingStructure, testing::ValuesIn(all_structures),
                         [](const auto& one) { return "Structure" + std::to_string(one.index); });

TEST_P(CreepingStructure, IsBumplessAtARestart) {
  Loop loop(config(Structure::inverse));
  for (int i = 0; i < 50; ++i) loop.cycle(20.0);
  loop.law.retune(config(GetParam()));
  loop.law.elapse(0.5);
  const double reference_um = loop.law.restart(loop.position_um());
  EXPECT_NEAR(loop.repeated(reference_um), loop.drive, 1e-9);
}

TEST_P(CreepingStructure, IsBumplessAtARetune) {
  Loop loop(config(Structure::inverse_pi));
  for (int i = 0; i < 50; ++i) loop.cycle(20.0);
  loop.law.retune(config(GetParam()));
  EXPECT_NEAR(loop.repeated(20.0), loop.drive, 1e-6);
  loop.law.commit(loop.drive);
  loop.law.retune(config(GetParam(), three_percent, {.kp = 0.1, .ki_per_s = 30.0}));
  EXPECT_NEAR(loop.repeated(20.0), loop.drive, 1e-6);
}

// I = limit - F for a limit that moves with the creep: from the first cycle in which the reference is within
// reach again, the integral demands no unreachable position.
TEST(CreepCompensation, DoesNotWindUpAtALimitThatCreeps) {
  Loop loop(config(Structure::pi, three_percent, {.kp = 0.0, .ki_per_s = 100.0}));
  for (int i = 0; i < 2000; ++i) {
    loop.cycle(27.0, 60.0);
    const double most_um = loop.law.predicted_um() + 100.0 * (27.0 - loop.position_um()) * dt_s;
    ASSERT_LE(loop.law.integral_um(), most_um + 1e-9) << i;
  }
  EXPECT_LT(loop.cycle(loop.position_um() - 0.5, 60.0).drive, 60.0);
}

// The creep of the model has zero weight: the drive is equal to the bit.
TEST(CreepCompensation, ChangesNoBitIfTheModelHasNoCreep) {
  Loop none(config(Structure::inverse_pi, std::nullopt));
  Loop zero(config(Structure::inverse_pi, model::OutputCreep::Config{.per_decade = 0.0}));
  for (int i = 0; i < 2000; ++i) {
    none.cycle(15.0 + 10.0 * std::sin(0.02 * i));
    zero.cycle(15.0 + 10.0 * std::sin(0.02 * i));
    ASSERT_EQ(none.drive, zero.drive) << i;
  }
}

TEST(CreepCompensation, AllocatesNothing) {
  Loop loop(config(Structure::inverse_pi));
  const std::uint64_t before = support::allocations_so_far();
  loop.law.settle();
  for (int i = 0; i < 100; ++i) loop.cycle(20.0);
  EXPECT_EQ(support::allocations_so_far(), before);
}

AxisConfig creeping_piezo() {
  AxisConfig config = support::piezo_axis();
  config.law.creep = three_percent;
  return config;
}

/// Returns the correction of the integral when tracking begins: the difference between position and model.
double offset_after_wipe_um(const AxisConfig& config, const AxisConfig& actuator) {
  IdealStage stage(actuator, model::Hysteresis(actuator.law.model).at_lower_threshold());
  stage.axis = Axis(config);
  EXPECT_TRUE(stage.tracks());
  return stage.axis.report().integral_um;
}

// With 10 ms at each threshold, most of the creep after the wipe is still outstanding when tracking begins.
TEST(CreepCompensation, IncludesTheCreepOfTheWipe) {
  EXPECT_NEAR(offset_after_wipe_um(creeping_piezo(), creeping_piezo()), 0.0, 1e-9);
  EXPECT_GT(std::abs(offset_after_wipe_um(support::piezo_axis(), creeping_piezo())), 0.3);
}

// The creep of the earlier motion has decayed: the actuator rested at the safe drive for a long time.
TEST(CreepCompensation, IncludesTheRestBeforeTheNextStart) {
  IdealStage stage(creeping_piezo(), model::Hysteresis(creeping_piezo().law.model).at_lower_threshold());
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 3000; ++i) stage.cycle();
  stage.axis.stop();
  ASSERT_TRUE(stage.reaches(AxisState::offline));
  stage.hold(1000.0);
  ASSERT_TRUE(stage.tracks());
  EXPECT_NEAR(stage.axis.report().integral_um, 0.0, 1e-9);
}

// The references wait, but the creep does not. The error is that of a cycle, 3 nm; with the time of the
// references it would be 25 nm.
TEST(CreepCompensation, ContinuesWhileTheReferencesWait) {
  AxisConfig config = creeping_piezo();
  config.law.structure = Structure::inverse;
  IdealStage stage(config, model::Hysteresis(config.law.model).at_lower_threshold());
  ASSERT_TRUE(stage.tracks());
  while (stage.axis.report().reference_um < 15.0) stage.cycle();
  constexpr double waited_s = 4 * cycle_s;
  stage.hold(waited_s);
  const auto later = [](AxisInput& in) {
    in.time_s += waited_s;
    in.waited_s = waited_s;
  };
  stage.cycle([&](AxisInput& in) {
    later(in);
    in.dt_s += waited_s;
  });
  stage.cycle(later);
  ASSERT_EQ(stage.axis.state(), AxisState::tracking) << to_string(stage.axis.fault().cause);
  EXPECT_NEAR(stage.axis.report().position_um, 15.0, 5e-3);
}

}  // namespace
}  // namespace hystcan::controller::creep_compensation_test
