#include "controller/control/axis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "tests/controller/control/ideal_stage.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::axis_test {
namespace {

AxisConfig excited_piezo(const Excitation::Config& excitation) {
  AxisConfig config = support::piezo_axis();
  config.excitation = excitation;
  return config;
}

TEST(Axis, DrivesNothingBeforeItIsStarted) {
  IdealStage stage;
  EXPECT_FALSE(stage.cycle().enable);
  EXPECT_EQ(stage.axis.state(), AxisState::offline);
}

TEST(Axis, WaitsForWhatItLacksAndSaysSo) {
  constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [block, disturb] : std::vector<std::pair<ArmingBlock, std::function<void(AxisInput&)>>>{
           {ArmingBlock::sensor_heartbeat, [](AxisInput& in) { in.health.sensor_alive = false; }},
           {ArmingBlock::amplifier_heartbeat, [](AxisInput& in) { in.health.amplifier_alive = false; }},
           {ArmingBlock::sensor_operational, [](AxisInput& in) { in.health.sensor_operational = false; }},
           {ArmingBlock::amplifier_operational,
            [](AxisInput& in) { in.health.amplifier_operational = false; }},
           {ArmingBlock::amplifier_ready, [](AxisInput& in) { in.health.amplifier_ready = false; }},
           {ArmingBlock::amplifier_output, [](AxisInput& in) { in.health.amplifier_output = not_a_number; }},
           {ArmingBlock::amplifier_output, [](AxisInput& in) { in.health.amplifier_output = -1.1; }},
           {ArmingBlock::amplifier_output, [](AxisInput& in) { in.health.amplifier_output = 101.1; }},
           {ArmingBlock::amplifier_rest, [](AxisInput& in) { in.health.amplifier_moves = true; }},
           {ArmingBlock::sample, [](AxisInput& in) { in.position_um.reset(); }}}) {
    IdealStage stage;
    stage.axis.start(false);
    for (int i = 0; i < 100; ++i) EXPECT_FALSE(stage.cycle(disturb).enable);
    EXPECT_EQ(stage.axis.state(), AxisState::waiting);
    EXPECT_EQ(stage.axis.report().arming_blocks, block) << to_string(block);
    stage.cycle();
    EXPECT_EQ(stage.axis.state(), AxisState::initialising) << "nothing else was missing";
  }
}

/// An amplifier whose output falls while its relay is open: what it commands when the relay closes is no
/// step.
TEST(Axis, FollowsAnOutputThatFallsBeforeTheAmplifierIsEnabled) {
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

TEST(Axis, HoldsTheOutputUntilTheAmplifierReportsThatItDrives) {
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

TEST(Axis, GoesToBothThresholdsAtStartUpToWipeTheMemoryOut) {
  IdealStage stage;
  stage.axis.start(false);
  ASSERT_TRUE(stage.reaches(AxisState::ready));
  EXPECT_EQ(stage.highest_drive, 100.0);
  EXPECT_EQ(stage.command.drive, 0.0);
}

TEST(Axis, TracksToTheInversesPrecisionAfterTheMemoryIsWipedOut) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  EXPECT_NEAR(stage.axis.report().position_um, 15.0, 1e-9);
  EXPECT_EQ(stage.axis.report().limits, limit::none);
}

struct FaultCase {
  const char* name;
  Cause cause;
  std::function<void(AxisInput&)> disturb;
  int cycles;  ///< until the axis is faulted

  friend void PrintTo(const FaultCase& fault, std::ostream* out) { *out << fault.name; }
};

void expect_the_safe_command_in_the_deciding_cycle_and_ever_after(IdealStage stage, const FaultCase& fault) {
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 100; ++i) stage.cycle();
  for (int i = 1; i < fault.cycles; ++i) {
    EXPECT_TRUE(stage.cycle(fault.disturb).enable) << "cycle " << i << " is still bridged";
  }
  const AxisCommand deciding = stage.cycle(fault.disturb);
  EXPECT_FALSE(deciding.enable);
  EXPECT_EQ(deciding.drive, 0.0);
  EXPECT_EQ(stage.axis.state(), AxisState::faulted);
  EXPECT_EQ(stage.axis.fault().cause, fault.cause);
  EXPECT_DOUBLE_EQ(stage.axis.fault().time_s, stage.time_s);
  EXPECT_FALSE(remedy(fault.cause).empty());

  for (int i = 0; i < 100; ++i)
    EXPECT_FALSE(stage.cycle().enable) << "the cause is gone, but the fault is latched";
  EXPECT_EQ(stage.axis.fault().cause, fault.cause);
}

class EveryFault : public testing::TestWithParam<FaultCase> {};

TEST_P(EveryFault, LeadsToTheSafeCommandInTheDecidingCycleAndLatches) {
  expect_the_safe_command_in_the_deciding_cycle_and_ever_after(IdealStage(), GetParam());
}

TEST_P(EveryFault, LeadsToTheSafeCommandInOpenLoopTooExceptTheFollowingError) {
  AxisConfig config = excited_piezo(Excitation::Hysteresis{.low = 10.0, .high = 90.0});
  if (GetParam().cause != Cause::following_error)
    return expect_the_safe_command_in_the_deciding_cycle_and_ever_after(IdealStage(config), GetParam());
  config.supervision.position_jump_um = 0.0;
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 100; ++i) stage.cycle(GetParam().disturb);
  EXPECT_EQ(stage.axis.state(), AxisState::tracking) << "there is no reference to lose";
}

INSTANTIATE_TEST_SUITE_P(
    Axis, EveryFault,
    testing::Values(
        FaultCase{"SampleMissing", Cause::sample_missing, [](AxisInput& in) { in.position_um.reset(); }, 4},
        FaultCase{"SensorStatus", Cause::sensor_status, [](AxisInput& in) { in.sensor_status_good = false; },
                  1},
        FaultCase{"PositionOutOfRange", Cause::position_implausible,
                  [](AxisInput& in) { in.position_um = 40.0; }, 1},
        FaultCase{"PositionNotANumber", Cause::position_implausible,
                  [](AxisInput& in) { in.position_um = std::numeric_limits<double>::quiet_NaN(); }, 1},
        FaultCase{"SensorSilent", Cause::sensor_silent, [](AxisInput& in) { in.health.sensor_alive = false; },
                  1},
        FaultCase{"AmplifierSilent", Cause::amplifier_silent,
                  [](AxisInput& in) { in.health.amplifier_alive = false; }, 1},
        FaultCase{"SampleLate", Cause::sample_late,
                  [](AxisInput& in) {
                    in.position_um.reset();
                    in.late_sample = true;
                  },
                  4},
        FaultCase{"SensorStopped", Cause::node_not_operational,
                  [](AxisInput& in) { in.health.sensor_operational = false; }, 1},
        FaultCase{"AmplifierStopped", Cause::node_not_operational,
                  [](AxisInput& in) { in.health.amplifier_operational = false; }, 1},
        FaultCase{"Emergency", Cause::node_emergency, [](AxisInput& in) { in.health.emergency = true; }, 1},
        FaultCase{"PositionJumped", Cause::position_jumped, [](AxisInput& in) { *in.position_um += 13.0; },
                  4},
        FaultCase{"BusPassive", Cause::bus_passive, [](AxisInput& in) { in.health.bus_passive = true; }, 10},
        FaultCase{"NodeRestarted", Cause::node_restarted, [](AxisInput& in) { in.health.restarted = true; },
                  1},
        FaultCase{"AmplifierFault", Cause::amplifier_fault,
                  [](AxisInput& in) { in.health.amplifier_fault = true; }, 1},
        FaultCase{"InterfaceDown", Cause::interface_down,
                  [](AxisInput& in) { in.health.interface_up = false; }, 1},
        FaultCase{"BusOff", Cause::bus_off, [](AxisInput& in) { in.health.bus_on = false; }, 1},
        FaultCase{"CycleOverrun", Cause::cycle_overrun, [](AxisInput& in) { in.dt_s = 0.011; }, 1},
        FaultCase{"FollowingError", Cause::following_error,
                  [](AxisInput& in) { in.position_um = 12.2 + 1e-3 * in.time_s; }, 3}),
    [](const auto& test) { return test.param.name; });

TEST(Axis, TripsWhereTheAmplifierNeverBecomesEnabled) {
  IdealStage stage;
  stage.axis.start(false);
  for (int i = 0; i < 1000; ++i) stage.cycle([](AxisInput& in) { in.health.amplifier_enabled = false; });
  EXPECT_EQ(stage.axis.fault().cause, Cause::amplifier_not_enabled);
}

TEST(Axis, BridgesSingleLossesButTripsWhereHalfOfTheSamplesAreLost) {
  IdealStage seldom;
  ASSERT_TRUE(seldom.tracks());
  for (int i = 0; i < 10'000; ++i)
    seldom.cycle([&](AxisInput& in) {
      if (i % 11 == 0) in.position_um.reset();
    });
  EXPECT_EQ(seldom.axis.state(), AxisState::tracking);

  IdealStage half;
  ASSERT_TRUE(half.tracks());
  for (int i = 0; i < 100; ++i)
    half.cycle([&](AxisInput& in) {
      if (i % 2 == 0) in.position_um.reset();
    });
  EXPECT_EQ(half.axis.fault().cause, Cause::sample_missing);
}

TEST(Axis, RefusesAFaultedAmplifierUnlessItIsAskedToClearTheFault) {
  const auto faulted = [](AxisInput& in) {
    in.health.amplifier_fault = true;
    in.health.amplifier_ready = false;
  };
  IdealStage strict;
  strict.axis.start(false);
  strict.cycle(faulted);
  EXPECT_EQ(strict.axis.fault().cause, Cause::amplifier_fault);

  IdealStage clearing;
  clearing.axis.start(true);
  const AxisCommand command = clearing.cycle(faulted);
  EXPECT_TRUE(command.clear_fault);
  EXPECT_FALSE(command.enable);
  EXPECT_TRUE(clearing.reaches(AxisState::tracking));
  EXPECT_FALSE(clearing.command.clear_fault) << "the clearing is requested only once";
}

TEST(Axis, RampsDownWithinTheSlewLimitAtAStopAndThenSwitchesOff) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 200; ++i) stage.cycle();
  double before = stage.command.drive;
  ASSERT_GT(before, 30.0);
  stage.axis.stop();
  while (stage.axis.state() != AxisState::offline) {
    const AxisCommand command = stage.cycle();
    ASSERT_GE(command.drive, before - 1000.0 * cycle_s * (1 + 1e-12));
    before = command.drive;
  }
  EXPECT_EQ(stage.command.drive, 0.0);
  EXPECT_FALSE(stage.command.enable);
}

TEST(Axis, StopsWithoutARampWhileItIsWaiting) {
  IdealStage stage;
  stage.axis.start(false);
  stage.axis.stop();
  EXPECT_FALSE(stage.cycle().enable);
  EXPECT_EQ(stage.axis.state(), AxisState::offline);
}

TEST(Axis, IsClearedOnlyWhereItIsFaultedAndThenStartsFromOffline) {
  IdealStage stage;
  EXPECT_FALSE(stage.axis.clear());
  ASSERT_TRUE(stage.tracks());
  EXPECT_FALSE(stage.axis.clear());
  stage.cycle([](AxisInput& in) { in.sensor_status_good = false; });
  ASSERT_EQ(stage.axis.state(), AxisState::faulted);
  EXPECT_TRUE(stage.axis.clear());
  EXPECT_FALSE(stage.axis.clear()) << "a clear is never queued";
  EXPECT_EQ(stage.axis.state(), AxisState::offline);
  EXPECT_EQ(stage.axis.fault().cause, Cause::none);
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(stage.cycle().enable) << "a clear does not start the axis";
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  EXPECT_NEAR(stage.axis.report().position_um, 15.0, 1e-9) << "its memory is wiped out again";
}

// A model that was identified with a lower threshold beyond the drive is the better one inside it. The upper
// threshold alone wipes out what the actuator remembers.
TEST(Axis, StartsFromTheUpperThresholdIfTheDriveDoesNotReachTheLowerOne) {
  AxisConfig config = support::piezo_axis();
  const model::Hysteresis actuator(config.law.model);
  model::HysteresisState unknown = actuator.at_lower_threshold();
  for (const double drive : {80.0, 30.0, 60.0, 10.0}) actuator.advance(unknown, drive);
  config.gate.drive_min = 5.0;
  config.gate.safe_drive = 10.0;
  IdealStage stage(config, unknown);
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  EXPECT_NEAR(stage.axis.report().position_um, 15.0, 1e-9);
  EXPECT_EQ(stage.highest_drive, 100.0);
}

TEST(Axis, TracksAgainAfterItWasStopped) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  stage.axis.stop();
  ASSERT_TRUE(stage.reaches(AxisState::offline));
  EXPECT_TRUE(stage.tracks());
}

TEST(Axis, DoesNotUseAJumpedSample) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  const double before = stage.command.drive;
  stage.cycle([](AxisInput& in) { *in.position_um += 13.0; });
  EXPECT_NEAR(stage.command.drive, before, 1e-6);
  EXPECT_TRUE(stage.axis.report().sample_missing);
  EXPECT_EQ(stage.axis.state(), AxisState::tracking);
}

// The drive rests, so the model says that the position has not moved.
TEST(Axis, DoesNotBelieveASecondJumpWhereItsDriveHasRested) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  for (int i = 0; i < 4; ++i) stage.cycle([](AxisInput& in) { in.position_um = 7.0; });
  EXPECT_EQ(stage.axis.fault().cause, Cause::position_jumped);
}

TEST(Axis, JudgesAnOscillationAnewAfterAStart) {
  AxisConfig config = support::piezo_axis();
  config.following_error.error_um = 100.0;
  config.supervision.position_jump_um = 0.0;
  config.supervision.position_min_um = -100.0;
  config.setpoint = {{.shape = Hold{.level_um = 1.0, .duration_s = 1.0}, .transition_s = 0.05}};
  IdealStage stage(config);
  const auto oscillate = [&](int half_periods) {
    for (int i = 0; i < 5 * half_periods && stage.axis.state() == AxisState::tracking; ++i)
      stage.cycle([i](AxisInput& in) { *in.position_um += i / 5 % 2 == 0 ? 8.0 : -8.0; });
    return stage.axis.fault().cause;
  };
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  EXPECT_EQ(oscillate(40), Cause::loop_unstable);
  ASSERT_TRUE(stage.axis.clear());
  ASSERT_TRUE(stage.tracks());
  EXPECT_EQ(oscillate(10), Cause::none);
}

TEST(Axis, TripsWhereItsDriveIsLimitedForTooLong) {
  AxisConfig config = support::piezo_axis();
  config.setpoint = {{.shape = Hold{.level_um = 40.0, .duration_s = 100.0}, .transition_s = 0.05}};
  config.following_error.error_um = 100.0;
  config.supervision.saturated_s = 0.2;
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  ASSERT_TRUE(stage.reaches(AxisState::faulted, 400));
  EXPECT_EQ(stage.axis.fault().cause, Cause::saturated);
  EXPECT_FALSE(stage.command.enable);
}

TEST(AxisInOpenLoop, RampsStraightToTheFirstDriveAndNotToTheModelsThresholds) {
  IdealStage stage(excited_piezo(Excitation::Hysteresis{.low = 20.0, .high = 60.0}));
  stage.axis.start(false);
  double before = 0.0;
  while (stage.axis.state() != AxisState::tracking) {
    stage.cycle();
    ASSERT_LE(stage.command.drive, before + 1000.0 * cycle_s * (1 + 1e-12)) << "wipe_slew_per_s";
    before = stage.command.drive;
  }
  EXPECT_EQ(stage.highest_drive, 20.0);
}

TEST(AxisInOpenLoop, AppliesTheExcitationWhateverThePosition) {
  const Excitation::Chirp chirp{.centre = 40.0, .amplitude = 10.0, .to_Hz = 100.0, .duration_s = 1.0};
  AxisConfig config = excited_piezo(chirp);
  config.supervision.position_jump_um = 0.0;
  config.supervision.frozen_cycles = 0;
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  const Excitation excitation(chirp);
  const double begun_s = stage.time_s;
  while (!stage.axis.report().point.finished) {
    const double position_um = stage.time_s > begun_s + 0.5 ? 30.0 : 0.0;
    stage.cycle([&](AxisInput& in) { in.position_um = position_um; });
    ASSERT_EQ(stage.command.drive, excitation.at(stage.time_s - begun_s));
    ASSERT_TRUE(std::isnan(stage.axis.report().reference_um)) << "there is none";
  }
  EXPECT_EQ(stage.axis.state(), AxisState::tracking) << "it holds the last drive until it is stopped";
  EXPECT_NEAR(stage.time_s - begun_s, 1.0, 1.5 * cycle_s);
}

TEST(AxisInOpenLoop, IsFinishedInTheCycleInWhichTheExcitationEnds) {
  IdealStage stage(
      excited_piezo(Excitation::Chirp{.centre = 40.0, .amplitude = 10.0, .to_Hz = 100.0, .duration_s = 1.0}));
  stage.axis.start(false);
  const auto at = [&](double time_s) {
    stage.cycle([time_s](AxisInput& in) {
      in.time_s = time_s;
      if (in.tracking_since_s) in.tracking_since_s = time_s;
    });
    return stage.axis.report().point.finished;
  };
  while (stage.axis.state() != AxisState::tracking) at(1.0);
  EXPECT_FALSE(at(std::nextafter(2.0, 0.0)));
  EXPECT_TRUE(at(2.0));
}

TEST(AxisInOpenLoop, ContinuesTheExcitationThroughALostSample) {
  IdealStage stage(excited_piezo(Excitation::Hysteresis{.slew_per_s = 100.0, .rest_s = 0.0}));
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 100; ++i) stage.cycle();
  const double before = stage.command.drive;
  stage.cycle([](AxisInput& in) { in.position_um.reset(); });
  EXPECT_TRUE(stage.axis.report().sample_missing);
  EXPECT_NEAR(stage.command.drive, before + 100.0 * cycle_s, 1e-9);
}

TEST(AxisInOpenLoop, LimitsASteepStepToTheSlewOfTheGate) {
  AxisConfig config = excited_piezo(Excitation::Steps{.centre = 50.0, .amplitude = 20.0, .period_s = 0.2});
  config.gate.slew_per_s = 1000.0;
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  std::uint8_t limits = limit::none;
  for (double before = stage.command.drive; !stage.axis.report().point.finished;
       before = stage.command.drive) {
    stage.cycle();
    ASSERT_LE(std::abs(stage.command.drive - before), 1000.0 * cycle_s * (1 + 1e-12));
    limits |= stage.axis.report().limits;
  }
  EXPECT_EQ(limits, limit::slew);
}

TEST(AxisInOpenLoop, RefusesAnExcitationThatTheGateWouldLimit) {
  for (const Excitation::Config& excitation :
       {Excitation::Config(Excitation::Hysteresis{.low = -1.0, .high = 100.0}),
        Excitation::Config(Excitation::Hysteresis{.low = 0.0, .high = 101.0}),
        Excitation::Config(Excitation::Hysteresis{.slew_per_s = 20'001.0}),
        Excitation::Config(Excitation::Steps{.centre = 98.0, .amplitude = 5.0}),
        Excitation::Config(Excitation::Chirp{.centre = 2.0, .amplitude = 5.0}),
        Excitation::Config(Excitation::Chirp{.amplitude = 10.0, .to_Hz = 400.0})})
    EXPECT_THROW(Axis(excited_piezo(excitation)), std::invalid_argument);
}

TEST(AxisInOpenLoop, RampsDownAtAStopInTheMiddleOfTheExcitation) {
  IdealStage stage(excited_piezo(Excitation::Hysteresis{.slew_per_s = 200.0}));
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 300; ++i) stage.cycle();
  double before = stage.command.drive;
  ASSERT_GT(before, 30.0);
  stage.axis.stop();
  while (stage.axis.state() != AxisState::offline) {
    ASSERT_GE(stage.cycle().drive, before - 1000.0 * cycle_s * (1 + 1e-12));
    before = stage.command.drive;
  }
  EXPECT_EQ(stage.command.drive, 0.0);
}

}  // namespace
}  // namespace hystcan::controller::axis_test
