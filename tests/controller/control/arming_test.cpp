// The arming of an axis: its first drive, the delay of the amplifier, and the verification of the amplifier's
// watchdog, which withholds commands.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/controller/control/ideal_stage.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::arming_test {
namespace {

// ---- the first drive

using Disturbance = std::function<void(AxisInput&)>;

Disturbance with_output(double output, bool enabled) {
  return [=](AxisInput& in) {
    in.health.amplifier_enabled = enabled;
    in.health.amplifier_output = output;
    in.position_um = 10.0;
  };
}

/// The gate is 10..110 V, so 1 % of its range is 1 V.
AxisConfig above_zero() {
  AxisConfig config = support::piezo_axis();
  config.gate = {.drive_min = 10.0, .drive_max = 110.0, .slew_per_s = 20'000.0, .safe_drive = 10.0};
  return config;
}

/// Returns the drive in the cycle after the axis was armed with this output.
double first_drive(const AxisConfig& config, double output, bool enabled) {
  IdealStage stage(config);
  stage.axis.start(false);
  stage.cycle(with_output(output, enabled));
  EXPECT_EQ(stage.axis.state(), AxisState::initialising);
  return stage.cycle(with_output(output, enabled)).drive;
}

TEST(ArmedDrive, IsLimitedToTheGateIfTheReadingIsOutside) {
  AxisConfig config = above_zero();
  config.start_up = MemorySource::assume;  // without a ramp
  EXPECT_EQ(first_drive(config, 110.5, true), 110.0);
  EXPECT_EQ(first_drive(config, 9.5, true), 10.0);
}

TEST(ArmedDrive, IgnoresADifferenceWithinTheReadingError) {
  IdealStage stage(above_zero());
  stage.axis.start(false);
  stage.cycle(with_output(60.0, false));
  EXPECT_EQ(stage.cycle(with_output(59.0, false)).drive, 60.0);
  EXPECT_EQ(stage.cycle(with_output(61.0, false)).drive, 60.0);
}

TEST(ArmedDrive, FollowsAReadingThatDiffersByMore) {
  IdealStage stage(above_zero());
  stage.axis.start(false);
  stage.cycle(with_output(60.0, false));
  EXPECT_EQ(stage.cycle(with_output(58.9, false)).drive, 58.9);
  EXPECT_EQ(stage.cycle(with_output(60.0, false)).drive, 60.0);
}

/// An amplifier whose output falls while its relay is open: the drive causes no step when the relay closes.
TEST(ArmedDrive, FollowsAnOutputThatFallsBeforeTheAmplifierIsEnabled) {
  IdealStage stage;
  double output = 60.0;
  const auto discharging = [&](AxisInput& in) {
    in.health.amplifier_enabled = false;
    in.health.amplifier_output = output;
    in.position_um = 0.3 * output;
  };
  stage.axis.start(false);
  stage.cycle(discharging);
  for (int i = 0; i < 300; ++i) {
    output *= 0.99;
    const AxisCommand command = stage.cycle(discharging);
    ASSERT_NEAR(command.drive, output, 1.01) << to_string(stage.axis.fault().cause);
  }
}

TEST(ArmedDrive, IgnoresAReadingThatIsNotANumber) {
  IdealStage stage(above_zero());
  stage.axis.start(false);
  stage.cycle(with_output(60.0, false));
  EXPECT_EQ(stage.cycle(with_output(std::numeric_limits<double>::quiet_NaN(), false)).drive, 60.0);
}

TEST(ArmedDrive, IsNotFollowedOnceTheAmplifierIsEnabled) {
  AxisConfig config = above_zero();
  config.start_up = MemorySource::assume;
  IdealStage stage(config);
  stage.axis.start(false);
  stage.cycle(with_output(60.0, true));
  EXPECT_EQ(stage.cycle(with_output(30.0, true)).drive, 60.0);
}

/// The actuator is at 60 V, even while the axis waits; the setpoint is a position, without feedback.
struct RaisedStage {
  IdealStage stage;

  explicit RaisedStage(double level_um) : stage(config_for(level_um), raised()) { stage.axis.start(false); }

  static AxisConfig config_for(double level_um) {
    AxisConfig config = support::piezo_axis();
    config.start_up = MemorySource::assume;
    config.gate.safe_drive = 60.0;
    config.law.structure = Structure::inverse;
    config.setpoint = {{.shape = Hold{.level_um = level_um, .duration_s = 1.0}, .transition_s = 0.05}};
    return config;
  }
  static model::HysteresisState raised() {
    const model::Hysteresis actuator(support::piezo_model());
    model::HysteresisState memory = actuator.at_lower_threshold(model::Hysteresis::default_capacity);
    actuator.advance(memory, 60.0);
    return memory;
  }
  void track() {
    for (int i = 0; i < 200; ++i) stage.cycle([](AxisInput& in) { in.health.amplifier_enabled = true; });
    ASSERT_EQ(stage.axis.state(), AxisState::tracking) << to_string(stage.axis.fault().cause);
  }
};

/// The fall from 60 V follows a branch that begins there.
TEST(ArmedDrive, IsPartOfTheModelsMemory) {
  RaisedStage raised(5.0);
  raised.track();
  EXPECT_NEAR(raised.stage.memory().output, 5.0, 1e-6);
}

/// The turning point at 20 V occurs before the amplifier is enabled.
TEST(ArmedDrive, IsPartOfTheMemoryWhileItFollowsTheOutput) {
  RaisedStage raised(12.0);
  const auto output = [&](double drive) {
    raised.stage.cycle([=](AxisInput& in) {
      in.health.amplifier_enabled = false;
      in.health.amplifier_output = drive;
    });
  };
  for (double drive = 60.0; drive >= 20.0; drive -= 2.0) output(drive);
  for (double drive = 22.0; drive <= 40.0; drive += 2.0) output(drive);
  ASSERT_EQ(raised.stage.axis.report().drive, 40.0) << to_string(raised.stage.axis.fault().cause);
  raised.track();
  EXPECT_NEAR(raised.stage.memory().output, 12.0, 1e-6);
}

// ---- until the amplifier is enabled

TEST(ArmedDrive, HoldsTheOutputUntilTheAmplifierReportsThatItDrives) {
  const auto not_yet_enabled = [](AxisInput& in) {
    in.health.amplifier_enabled = false;
    in.health.amplifier_output = 7.0;
  };
  IdealStage stage;
  stage.axis.start(false);
  stage.cycle(not_yet_enabled);
  ASSERT_EQ(stage.axis.state(), AxisState::initialising);
  for (int i = 0; i < 400; ++i) {
    const AxisCommand command = stage.cycle(not_yet_enabled);
    EXPECT_TRUE(command.enable);
    EXPECT_EQ(command.drive, 7.0);
  }
  EXPECT_EQ(stage.axis.state(), AxisState::initialising);
  EXPECT_TRUE(stage.reaches(AxisState::ready)) << "the whole ramp follows";
  EXPECT_EQ(stage.highest_drive, 100.0);
}

Disturbance exact(bool enabled) {
  return [=](AxisInput& in) {
    in.dt_s = in.cycle_s = exact_cycle_s;
    in.health.amplifier_enabled = enabled;
  };
}

/// Counts the cycles in which the axis waits for its amplifier, from the cycle after the arming.
int cycles_until_connected(IdealStage& stage) {
  int cycles = 0;
  for (stage.cycle(exact(true)); stage.axis.report().arming_blocks == ArmingBlock::enabled;
       stage.cycle(exact(true)))
    ++cycles;
  return cycles;
}

AxisConfig with_delay_of_eight_cycles() {
  AxisConfig config = support::piezo_axis();
  config.enable_delay = std::chrono::nanoseconds(7'812'500);
  return config;
}

TEST(EnableDelay, IsCountedFromTheFirstCommandWithEnable) {
  IdealStage stage(with_delay_of_eight_cycles());
  stage.axis.start(false);
  stage.cycle(exact(false));
  ASSERT_EQ(stage.axis.state(), AxisState::initialising);
  EXPECT_EQ(cycles_until_connected(stage), 8);
}

TEST(EnableDelay, IsRespectedAtEachStart) {
  IdealStage stage(with_delay_of_eight_cycles());
  for (int i = 0; i < 3; ++i) {
    stage.axis.start(false);
    stage.cycle(exact(true));
    ASSERT_EQ(stage.axis.state(), AxisState::initialising);
    EXPECT_EQ(cycles_until_connected(stage), 8);
    stage.axis.stop();
    ASSERT_TRUE(stage.reaches(AxisState::offline));
  }
}

TEST(EnableDelay, DoesNotReplaceTheReportOfTheAmplifierAtALaterStart) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  stage.axis.stop();
  ASSERT_TRUE(stage.reaches(AxisState::offline));
  stage.axis.start(false);
  for (int i = 0; i < 100; ++i) stage.cycle(exact(false));
  EXPECT_EQ(stage.axis.report().arming_blocks, ArmingBlock::enabled);
}

TEST(StopBeforeTheAmplifierIsEnabled, SwitchesOffAtOnceAtAnyOutput) {
  IdealStage stage;
  stage.axis.start(false);
  for (int i = 0; i < 3; ++i) stage.cycle(with_output(30.0, false));
  ASSERT_EQ(stage.axis.state(), AxisState::initialising);
  stage.axis.stop();
  EXPECT_FALSE(stage.cycle(with_output(30.0, false)).enable);
  EXPECT_EQ(stage.axis.state(), AxisState::offline);
}

TEST(StopAfterTheAmplifierIsEnabled, RampsDown) {
  IdealStage stage;
  stage.axis.start(false);
  for (int i = 0; i < 3; ++i) stage.cycle(with_output(30.0, true));
  ASSERT_EQ(stage.axis.state(), AxisState::initialising);
  stage.axis.stop();
  EXPECT_TRUE(stage.cycle(with_output(30.0, true)).enable);
}

// ---- the watchdog

AxisConfig with_verification() {
  AxisConfig config = support::piezo_axis();
  config.verify_watchdog = true;
  return config;
}

/// An axis whose commands are withheld since the last cycle.
struct WithheldAxis {
  IdealStage stage{with_verification()};

  WithheldAxis() {
    stage.axis.start(false);
    for (int i = 0; i < 500 && !stage.command.withheld; ++i) stage.cycle(exact(true));
    EXPECT_TRUE(stage.command.withheld);
  }
  AxisCommand cycle(const Disturbance& disturb = {}) {
    return stage.cycle([&](AxisInput& in) {
      exact(true)(in);
      if (disturb) disturb(in);
    });
  }
};

TEST(WatchdogTrial, BeginsAtTheSafeDriveAfterTheRampThere) {
  IdealStage stage(with_verification());
  const auto at_30_V = [&](AxisInput& in) {
    with_output(30.0, true)(in);
    in.position_um = 0.3 * (stage.command.enable ? stage.command.drive : 30.0);
  };
  stage.axis.start(false);
  stage.cycle(at_30_V);
  for (int i = 1; i <= 30; ++i) {  // at wipe_slew, 1000 V/s
    const AxisCommand command = stage.cycle(at_30_V);
    EXPECT_NEAR(command.drive, 30.0 - i, 1e-9);
    EXPECT_TRUE(command.enable);
    EXPECT_FALSE(command.withheld);
    EXPECT_EQ(stage.axis.report().arming_blocks, ArmingBlock::watchdog);
  }
  const AxisCommand command = stage.cycle(with_output(0.0, true));
  EXPECT_TRUE(command.withheld);
  EXPECT_TRUE(command.enable) << "the amplifier stays enabled until it trips";
  EXPECT_EQ(command.drive, 0.0);
  EXPECT_EQ(stage.axis.report().arming_blocks, ArmingBlock::watchdog);
}

TEST(WatchdogTrial, LastsForASecond) {
  WithheldAxis axis;
  int withheld = 0;
  for (; axis.stage.command.withheld && withheld < 2000; ++withheld) axis.cycle();
  EXPECT_EQ(withheld, 1024);
  EXPECT_EQ(axis.stage.axis.fault().cause, Cause::watchdog_failed);
}

TEST(WatchdogTrial, EndsWithTheSafeCommandIfItFails) {
  WithheldAxis axis;
  while (axis.stage.axis.state() != AxisState::faulted) axis.cycle();
  EXPECT_FALSE(axis.stage.command.withheld);
  EXPECT_FALSE(axis.stage.command.enable);
}

TEST(WatchdogTrial, PassesByTheTripAndArmsTheAxisAgain) {
  WithheldAxis axis;
  const auto trip = [](AxisInput& in) { in.health.amplifier_fault = true; };
  EXPECT_FALSE(axis.cycle(trip).enable);
  EXPECT_EQ(axis.stage.axis.state(), AxisState::waiting);
  EXPECT_TRUE(axis.cycle(trip).clear_fault) << "though the start did not ask for it";
  EXPECT_TRUE(axis.stage.reaches(AxisState::tracking));
}

TEST(WatchdogTrial, IgnoresTheEmergencyOfTheTrip) {
  WithheldAxis axis;
  EXPECT_TRUE(axis.cycle([](AxisInput& in) { in.health.emergency = true; }).withheld);
}

TEST(WatchdogTrial, IsSupervised) {
  WithheldAxis axis;
  const AxisCommand command = axis.cycle([](AxisInput& in) { in.health.bus_on = false; });
  EXPECT_EQ(axis.stage.axis.fault().cause, Cause::bus_off);
  EXPECT_FALSE(command.withheld);
}

TEST(WatchdogTrial, IsEndedByAStop) {
  WithheldAxis axis;
  axis.stage.axis.stop();
  EXPECT_FALSE(axis.cycle().withheld);
  EXPECT_EQ(axis.stage.axis.state(), AxisState::offline);
}

TEST(WatchdogTrial, RestartsAtTheStartAfterAStop) {
  WithheldAxis axis;
  axis.stage.axis.stop();
  axis.cycle();
  axis.stage.axis.start(false);
  axis.cycle();
  ASSERT_EQ(axis.stage.axis.state(), AxisState::initialising);
  const AxisCommand command = axis.cycle([](AxisInput& in) { in.health.amplifier_enabled = false; });
  EXPECT_FALSE(command.withheld) << "the amplifier is not enabled yet";
  EXPECT_EQ(axis.stage.axis.report().arming_blocks, ArmingBlock::enabled);
}

TEST(WatchdogTrial, ReportsItsTimeInTheCycleThatEndsIt) {
  WithheldAxis axis;
  for (int i = 0; i < 9; ++i) axis.cycle();
  EXPECT_FALSE(axis.stage.axis.report().watchdog_tripped_after_s);
  axis.cycle([](AxisInput& in) { in.health.amplifier_fault = true; });
  EXPECT_NEAR(axis.stage.axis.report().watchdog_tripped_after_s.value_or(0.0), 0.010, 0.0015);
  axis.cycle();
  EXPECT_FALSE(axis.stage.axis.report().watchdog_tripped_after_s);
}

}  // namespace
}  // namespace hystcan::controller::arming_test
