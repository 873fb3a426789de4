// An amplifier that reports that it is enabled, and correctly reports an output that differs from the
// command: its interlock is open, or its supply ends below the range. The ramp of the start-up waits for the
// output, and the stage makes no step when the output returns.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "controller/control/output_check.h"
#include "tests/controller/control/ideal_stage.h"
#include "tests/support/fault_rig.h"
#include "tests/support/shows.h"

namespace hystcan::support::output_check_test {
namespace {

using controller::ArmingBlock;
using controller::AxisInput;
using controller::AxisState;
using controller::Cause;
using controller::IdealStage;
using controller::OutputCheck;
using std::chrono::seconds;

/// Allowed difference: 5 % of the range, and the motion of the ramp while a status is under way and until the
/// next one.
double reach(const controller::AxisConfig& axis, double age_s, int cycles_to_next) {
  const double lag_s = 1.0 / (2.0 * std::numbers::pi * axis.delays.amplifier_bandwidth_Hz);
  return 0.05 * (axis.gate.drive_max - axis.gate.drive_min) +
         axis.wipe_slew_per_s * (age_s + 4e-3 + 5.0 * lag_s + 1e-3 * cycles_to_next);
}

// The output creeps to the command.
TEST(OutputDiffers, IsTheCauseBeforeTheDriveIsFarBeyondTheOutput) {
  shows("S-032");
  config::Config config = one_axis();
  config.axes[0].twin.plant.amplifier.slew_per_s = 1.0;
  FaultRig rig(config);
  rig.start();
  double commanded = 0.0;
  for (int i = 0; i < 3000 && rig.axis().state() != AxisState::faulted; ++i) {
    rig.run_for(std::chrono::milliseconds(1));
    commanded = std::max(commanded, rig.axis().report().drive);
  }
  EXPECT_EQ(to_string(rig.axis().fault().cause), "output differs");
  EXPECT_LE(commanded, reach(config.axes[0].control, 1e-3, 11));
  EXPECT_EQ(rig.monitor().violations(), 0u) << rig.monitor().found().front();
}

/// Reports the output of an amplifier whose interlock is open until `closes_s`.
void with_interlock(AxisInput& in, double closes_s) {
  in.health.output_reported = true;
  if (in.time_s < closes_s) in.health.amplifier_output = 0.0;
}

TEST(OutputDiffers, HoldsTheRampWhileAnInterlockIsOpen) {
  shows("S-008");
  IdealStage stage;
  constexpr double closes_s = 0.4;
  stage.axis.start(false);
  while (stage.time_s < closes_s - controller::cycle_s)
    stage.cycle([&](AxisInput& in) { with_interlock(in, closes_s); });
  EXPECT_EQ(stage.axis.state(), AxisState::initialising);
  EXPECT_EQ(stage.axis.report().arming_blocks, ArmingBlock::output);
  EXPECT_LE(stage.highest_drive, reach(stage.axis.config(), 0.0, 1));
  for (int i = 0; i < 3000 && stage.axis.state() != AxisState::tracking; ++i)
    stage.cycle([&](AxisInput& in) { with_interlock(in, closes_s); });
  EXPECT_EQ(stage.axis.state(), AxisState::tracking);
}

TEST(OutputDiffers, IsTheCauseIfThePositionDoesNotMove) {
  IdealStage stage;
  stage.axis.start(false);
  for (int i = 0; i < 1000 && stage.axis.state() != AxisState::faulted; ++i)
    stage.cycle([](AxisInput& in) {
      with_interlock(in, 10.0);
      in.position_um = 0.0;
    });
  EXPECT_EQ(to_string(stage.axis.fault().cause), "output differs");
}

TEST(OutputDiffers, EndsTrackingWithinTwoHundredMilliseconds) {
  shows("S-032");
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  const double from_s = stage.time_s;
  while (stage.axis.state() == AxisState::tracking && stage.time_s < from_s + 1.0)
    stage.cycle([&](AxisInput& in) {
      in.health.output_reported = true;
      in.health.amplifier_output += 20.0;
    });
  EXPECT_EQ(to_string(stage.axis.fault().cause), "output differs");
  EXPECT_LE(stage.time_s - from_s, 0.2);
}

/// Returns the number of cycles of 1/1024 s from the beginning of a large difference until it becomes the
/// cause.
int patience_cycles(IdealStage& stage) {
  int cycles = 0;
  for (; stage.axis.state() != AxisState::faulted && cycles < 1000; ++cycles)
    stage.cycle([](AxisInput& in) {
      in.dt_s = in.cycle_s = 1.0 / 1024.0;
      in.health.output_reported = true;
      in.health.amplifier_output = in.health.amplifier_output > 50.0 ? 20.0 : 80.0;
    });
  EXPECT_EQ(to_string(stage.axis.fault().cause), "output differs");
  return cycles;
}

TEST(OutputDiffers, IsTheCauseAfter50MillisecondsOrHalfASecondInARamp) {
  IdealStage tracking, ramping;
  ASSERT_TRUE(tracking.tracks());
  for (int i = 0; i < 300; ++i) tracking.cycle();
  EXPECT_EQ(patience_cycles(tracking), 52);
  ramping.axis.start(false);
  while (ramping.command.drive < 10.0) ramping.cycle();
  EXPECT_EQ(patience_cycles(ramping), 513);
}

// The last status is from before the start; the next one has not arrived.
TEST(OutputDiffers, IsClearedAtTheNextStart) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 300; ++i) stage.cycle();
  patience_cycles(stage);
  ASSERT_EQ(stage.axis.clear(), std::nullopt);
  stage.axis.start(false);
  for (int i = 0; i < 20; ++i) {
    stage.cycle([i](AxisInput& in) {
      in.health.output_reported = true;
      in.health.status_age_s = 0.02 + 1e-3 * i;
    });
    EXPECT_NE(stage.axis.report().arming_blocks, ArmingBlock::output);
  }
  EXPECT_EQ(stage.axis.state(), AxisState::initialising);
}

AxisInput reported(double output, double status_age_s = 0.0) {
  AxisInput in;
  in.dt_s = in.cycle_s = 1e-3;
  in.health.amplifier_output = output;
  in.health.output_reported = true;
  in.health.status_age_s = status_age_s;
  return in;
}

// Steps of 80 V through a lag of 1 to 1000 ms, with an amplifier that is configured for this lag.
TEST(OutputDiffers, AcceptsAmplifierWithConfiguredLag) {
  for (const double lag_s : {1e-3, 0.03, 0.1, 0.3, 1.0}) {
    OutputCheck check(100.0, lag_s);
    check.restart(10.0);
    double output = 10.0, longest_s = 0.0;
    for (int i = 0; i < 40'000; ++i) {
      const double drive = i / 4000 % 2 == 0 ? 10.0 : 90.0;
      output += (drive - output) * 1e-3 / (lag_s + 1e-3);
      check.step(drive, 2e4, reported(output));
      longest_s = std::max(longest_s, check.differs_for_s());
    }
    EXPECT_EQ(longest_s, 0.0) << lag_s;
  }
}

}  // namespace
}  // namespace hystcan::support::output_check_test
