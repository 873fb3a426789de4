// The ramps of a start-up and of a stop: their range, their slew and their rests.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/controller/control/ideal_stage.h"
#include "tests/support/drive_step.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::axis_ramps_test {
namespace {

constexpr double rounding = 1e-9;

/// Returns the drives of each cycle until the axis is in this state.
std::vector<double> drives_until(IdealStage& stage, AxisState state) {
  std::vector<double> drives;
  while (stage.axis.state() != state && drives.size() < 5000) drives.push_back(stage.cycle().drive);
  EXPECT_EQ(stage.axis.state(), state);
  return drives;
}

TEST(AxisRamps, ReachBothThresholdsAtStartUp) {
  IdealStage stage;
  stage.axis.start(false);
  ASSERT_TRUE(stage.reaches(AxisState::ready));
  EXPECT_EQ(stage.highest_drive, 100.0);
  EXPECT_EQ(stage.command.drive, 0.0);
}

// A model identified with a lower threshold beyond the drive is more accurate within the drive range. The
// upper threshold alone wipes out the actuator's memory.
TEST(AxisRamps, WipeTheMemoryByTheUpperThresholdAlone) {
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

/// The thresholds of the model, 0 and 100 V, are both outside the gate.
AxisConfig narrow_gate() {
  AxisConfig config = support::piezo_axis();
  config.gate = {.drive_min = 10.0, .drive_max = 80.0, .slew_per_s = 20'000.0, .safe_drive = 10.0};
  return config;
}

TEST(AxisRamps, StayWithinTheGate) {
  IdealStage stage(narrow_gate());
  stage.axis.start(false);
  std::vector<double> drives = drives_until(stage, AxisState::ready);
  EXPECT_EQ(*std::ranges::max_element(drives), 80.0);
  EXPECT_EQ(*std::ranges::min_element(drives), 10.0);
}

TEST(AxisRamps, AreLimitedByTheSlewOfTheGate) {
  AxisConfig config = support::piezo_axis();
  config.gate.slew_per_s = 500.0;  // wipe_slew is 1000 V/s
  config.setpoint = {{.shape = Hold{.level_um = 15.0, .duration_s = 1.0}, .transition_s = 0.5}};
  IdealStage stage(config);
  stage.axis.start(false);
  EXPECT_NEAR(support::largest_step(drives_until(stage, AxisState::ready)), 500.0 * cycle_s, rounding);
  ASSERT_TRUE(stage.reaches(AxisState::tracking));
  for (int i = 0; i < 700; ++i) stage.cycle();
  stage.axis.stop();
  EXPECT_NEAR(support::largest_step(drives_until(stage, AxisState::offline)), 500.0 * cycle_s, rounding);
}

TEST(AxisRamps, FallEnabledWithinTheSlewLimitAtAStopAndThenSwitchOff) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 200; ++i) stage.cycle();
  double before = stage.command.drive;
  ASSERT_GT(before, 30.0);
  stage.axis.stop();
  while (stage.cycle().drive > 0.0) {
    ASSERT_GE(stage.command.drive, before - 1000.0 * cycle_s * (1 + 1e-12));
    before = stage.command.drive;
    EXPECT_TRUE(stage.command.enable);
    EXPECT_EQ(stage.axis.state(), AxisState::ready);
  }
  EXPECT_LE(before, 1000.0 * cycle_s * (1 + 1e-12)) << "the last step is no larger";
  EXPECT_EQ(stage.command.drive, 0.0);
  EXPECT_FALSE(stage.command.enable);
  EXPECT_EQ(stage.axis.state(), AxisState::offline);
}

TEST(AxisRamps, RestAtEachThresholdForTheConfiguredTime) {
  AxisConfig config = support::piezo_axis();
  config.wipe_dwell_s = 8 * exact_cycle_s;
  IdealStage stage(config);
  stage.axis.start(false);
  int at_the_upper = 0;
  int at_the_lower = 0;
  while (stage.axis.state() != AxisState::ready) {
    stage.cycle([](AxisInput& in) { in.dt_s = in.cycle_s = exact_cycle_s; });
    if (stage.command.drive == 100.0) ++at_the_upper;
    if (stage.command.drive == 0.0 && at_the_upper > 0) ++at_the_lower;
  }
  EXPECT_EQ(at_the_upper, 8);
  EXPECT_EQ(at_the_lower, 8);
}

TEST(AxisRamps, RestForTheWholeTimeAfterAnInterruptedStart) {
  AxisConfig config = support::piezo_axis();
  config.wipe_dwell_s = 0.1;
  IdealStage stage(config);
  stage.axis.start(false);
  while (stage.command.drive < 100.0) stage.cycle();
  for (int i = 0; i < 50; ++i) stage.cycle();
  stage.axis.stop();
  ASSERT_TRUE(stage.reaches(AxisState::offline));
  stage.axis.start(false);
  const std::vector<double> drives = drives_until(stage, AxisState::ready);
  EXPECT_NEAR(static_cast<double>(std::ranges::count(drives, 100.0)), 100.0, 1.0);
}

}  // namespace
}  // namespace hystcan::controller::axis_ramps_test
