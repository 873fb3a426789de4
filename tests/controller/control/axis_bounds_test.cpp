// What an axis must not do at its bounds: ramps stay within the gate, a fault stays what it was, and a stop
// does not hide it. Then what the axis reports.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/controller/control/ideal_stage.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::axis_bounds_test {
namespace {

constexpr double rounding = 1e-9;

/// The drives of each cycle until the axis is in this state.
std::vector<double> drives_until(IdealStage& stage, AxisState state) {
  std::vector<double> drives;
  while (stage.axis.state() != state && drives.size() < 5000) drives.push_back(stage.cycle().drive);
  EXPECT_EQ(stage.axis.state(), state);
  return drives;
}

double largest_step(const std::vector<double>& drives) {
  double largest = 0.0;
  for (std::size_t i = 1; i < drives.size(); ++i)
    largest = std::max(largest, std::abs(drives[i] - drives[i - 1]));
  return largest;
}

// ---- the ramps

/// The thresholds of the model, 0 and 100 V, are both outside of the gate.
AxisConfig narrow_gate() {
  AxisConfig config = support::piezo_axis();
  config.gate = {.drive_min = 10.0, .drive_max = 80.0, .slew_per_s = 20'000.0, .safe_drive = 10.0};
  return config;
}

TEST(AxisRamps, GoNoFurtherThanTheGateOnTheWayToTheThresholds) {
  IdealStage stage(narrow_gate());
  stage.axis.start(false);
  std::vector<double> drives = drives_until(stage, AxisState::ready);
  EXPECT_EQ(*std::ranges::max_element(drives), 80.0);
  EXPECT_EQ(*std::ranges::min_element(drives), 10.0);
}

TEST(AxisRamps, AreNoFasterThanTheGateWhereItsSlewIsTheSmallerOne) {
  AxisConfig config = support::piezo_axis();
  config.gate.slew_per_s = 500.0;  // wipe_slew is 1000 V/s
  config.setpoint = {{.shape = Hold{.level_um = 15.0, .duration_s = 1.0}, .transition_s = 0.5}};
  IdealStage stage(config);
  stage.axis.start(false);
  EXPECT_NEAR(largest_step(drives_until(stage, AxisState::ready)), 500.0 * cycle_s, rounding);
  ASSERT_TRUE(stage.reaches(AxisState::tracking));
  for (int i = 0; i < 700; ++i) stage.cycle();
  stage.axis.stop();
  EXPECT_NEAR(largest_step(drives_until(stage, AxisState::offline)), 500.0 * cycle_s, rounding);
}

TEST(AxisRamps, StayEnabledUntilTheSafeDriveIsReached) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 200; ++i) stage.cycle();
  stage.axis.stop();
  while (stage.cycle().drive > 0.0) {
    EXPECT_TRUE(stage.command.enable);
    EXPECT_EQ(stage.axis.state(), AxisState::ready);
  }
  EXPECT_FALSE(stage.command.enable);
  EXPECT_EQ(stage.axis.state(), AxisState::offline);
}

TEST(AxisRamps, RestAtEachThresholdForTheConfiguredTime) {
  constexpr double exact_cycle_s = 1.0 / 1024.0;
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

TEST(AxisRamps, RestForTheWholeTimeAlsoAfterAnInterruptedStart) {
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

TEST(AxisWaiting, LastsUntilTheAmplifiersOutputRests) {
  IdealStage stage;
  stage.axis.start(false);
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(stage.cycle([](AxisInput& in) { in.health.amplifier_moves = true; }).enable);
    EXPECT_EQ(stage.axis.state(), AxisState::waiting);
  }
  EXPECT_TRUE(stage.reaches(AxisState::tracking));
}

TEST(AxisReady, HoldsItsDriveEnabledUntilEveryAxisIsReady) {
  IdealStage stage;
  stage.axis.start(false);
  ASSERT_TRUE(stage.reaches(AxisState::ready));
  for (int i = 0; i < 100; ++i) {
    const AxisCommand command = stage.cycle([](AxisInput& in) { in.tracking_since_s.reset(); });
    EXPECT_TRUE(command.enable);
    EXPECT_EQ(command.drive, 0.0);
    EXPECT_EQ(stage.axis.state(), AxisState::ready);
  }
}

TEST(AxisReady, BeginsToTrackOnlyInACycleWithASample) {
  IdealStage stage;
  stage.axis.start(false);
  ASSERT_TRUE(stage.reaches(AxisState::ready));
  EXPECT_TRUE(stage.cycle([](AxisInput& in) { in.position_um.reset(); }).enable);
  EXPECT_EQ(stage.axis.state(), AxisState::ready);
  stage.cycle();
  EXPECT_EQ(stage.axis.state(), AxisState::tracking);
}

// ---- the fault

TEST(AxisFault, KeepsItsFirstCauseAndTime) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  stage.axis.trip(Cause::another_controller, 1.5);
  stage.axis.trip(Cause::interface_down, 2.5);
  EXPECT_EQ(stage.axis.fault().cause, Cause::another_controller);
  EXPECT_EQ(stage.axis.fault().time_s, 1.5);
}

TEST(AxisFault, StaysAndStaysSafeAtAStop) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 200; ++i) stage.cycle();
  stage.cycle([](AxisInput& in) { in.sensor_status_good = false; });
  ASSERT_EQ(stage.axis.state(), AxisState::faulted);
  stage.axis.stop();
  for (int i = 0; i < 100; ++i) {
    const AxisCommand command = stage.cycle();
    EXPECT_FALSE(command.enable);
    EXPECT_EQ(command.drive, 0.0);
    EXPECT_EQ(stage.axis.state(), AxisState::faulted);
  }
  EXPECT_EQ(stage.axis.fault().cause, Cause::sensor_status);
}

TEST(AxisFault, DuringTheRampOfAStopIsSafeAtOnce) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 200; ++i) stage.cycle();
  stage.axis.stop();
  stage.cycle();
  ASSERT_GT(stage.command.drive, 10.0);
  const AxisCommand command = stage.cycle([](AxisInput& in) { in.sensor_status_good = false; });
  EXPECT_FALSE(command.enable);
  EXPECT_EQ(command.drive, 0.0);
  EXPECT_EQ(stage.axis.state(), AxisState::faulted);
}

TEST(AxisFault, OfAnAmplifierIsClearedWithTheNextStartAfterClear) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  const auto faulted = [](AxisInput& in) {
    in.health.amplifier_fault = true;
    in.health.amplifier_ready = false;
  };
  stage.cycle(faulted);
  ASSERT_EQ(stage.axis.fault().cause, Cause::amplifier_fault);
  ASSERT_TRUE(stage.axis.clear());
  stage.axis.start(false);
  EXPECT_TRUE(stage.cycle(faulted).clear_fault);
  EXPECT_EQ(stage.axis.state(), AxisState::waiting);
}

TEST(AxisFault, OfAnAmplifierIsClearedOnlyInTheStartThatWasToldToClearIt) {
  const auto faulted = [](AxisInput& in) {
    in.health.amplifier_fault = true;
    in.health.amplifier_ready = false;
  };
  IdealStage stage;
  stage.axis.start(true);
  ASSERT_TRUE(stage.reaches(AxisState::tracking));
  stage.axis.stop();
  ASSERT_TRUE(stage.reaches(AxisState::offline));
  stage.axis.start(false);
  EXPECT_FALSE(stage.cycle(faulted).clear_fault);
  EXPECT_EQ(stage.axis.fault().cause, Cause::amplifier_fault);
}

/// In open loop the drive rises by 10 V/s while the position stands still. The gate is symmetrical.
TEST(AxisFault, OfAFrozenPositionIsJudgedByTheWholeRangeOfTheDrive) {
  AxisConfig config = support::piezo_axis();
  config.gate.drive_min = -100.0;
  config.supervision.frozen_cycles = 50;
  config.supervision.position_jump_um = 0.0;
  config.excitation = Excitation::Hysteresis{.low = 0.0, .high = 90.0, .slew_per_s = 10.0, .rest_s = 0.0};
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  const auto frozen = [](AxisInput& in) { in.position_um = 5.0; };
  for (int i = 0; i < 390; ++i) stage.cycle(frozen);
  EXPECT_EQ(stage.axis.state(), AxisState::tracking) << "3.9 V";
  for (int i = 0; i < 20; ++i) stage.cycle(frozen);
  EXPECT_EQ(stage.axis.fault().cause, Cause::position_frozen) << "4.1 V of 200 V";
}

// ---- the report

TEST(AxisReportTest, HasTheStateAndTheDriveOfTheCommand) {
  IdealStage stage;
  stage.axis.start(false);
  while (stage.axis.state() != AxisState::tracking) {
    stage.cycle();
    ASSERT_EQ(stage.axis.report().state, stage.axis.state());
    ASSERT_EQ(stage.axis.report().drive, stage.command.drive);
    ASSERT_EQ(stage.axis.report().cause, Cause::none);
  }
}

TEST(AxisReportTest, HasCauseAndTimeOfTheFault) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  stage.cycle([](AxisInput& in) { in.sensor_status_good = false; });
  EXPECT_EQ(stage.axis.report().state, AxisState::faulted);
  EXPECT_EQ(stage.axis.report().cause, Cause::sensor_status);
  EXPECT_EQ(stage.axis.report().fault_time_s, stage.time_s);
  EXPECT_EQ(stage.axis.report().drive, 0.0);
}

TEST(AxisReportTest, SaysInEachCycleWhetherTheSampleIsMissing) {
  IdealStage stage;
  const auto lost = [](AxisInput& in) { in.position_um.reset(); };
  stage.cycle(lost);
  EXPECT_TRUE(stage.axis.report().sample_missing) << "also where the axis is not driven";
  stage.cycle();
  EXPECT_FALSE(stage.axis.report().sample_missing);
  ASSERT_TRUE(stage.tracks());
  stage.cycle(lost);
  EXPECT_TRUE(stage.axis.report().sample_missing);
  stage.cycle();
  EXPECT_FALSE(stage.axis.report().sample_missing);
}

TEST(AxisReportTest, KeepsTheLastPositionWhereTheSampleIsMissing) {
  IdealStage stage;
  stage.cycle([](AxisInput& in) { in.position_um = 7.25; });
  stage.cycle([](AxisInput& in) { in.position_um.reset(); });
  EXPECT_EQ(stage.axis.report().position_um, 7.25);
}

TEST(AxisReportTest, HasTheLimitsOfThisCycleAlone) {
  AxisConfig config = support::piezo_axis();
  config.excitation = Excitation::Steps{.centre = 50.0, .amplitude = 20.0, .period_s = 0.2};
  config.gate.slew_per_s = 1000.0;
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  while (stage.axis.report().limits == limit::none) stage.cycle();
  EXPECT_EQ(stage.axis.report().limits, limit::slew);
  for (int i = 0; i < 50; ++i) stage.cycle();
  EXPECT_EQ(stage.axis.report().limits, limit::none) << "the step is over";
}

TEST(AxisReportTest, HasTheDemandToTheInverse) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  EXPECT_NEAR(stage.axis.report().demand_um, 15.0, 1e-6) << "at rest on an ideal stage: the reference";
}

TEST(AxisReportTest, HasTheArrivalOnlyWhileTheAxisTracks) {
  AxisConfig config = support::piezo_axis();
  config.in_position = {
      .tolerance_um = 0.1, .window = std::chrono::milliseconds(5), .timeout = std::chrono::milliseconds(100)};
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  EXPECT_EQ(stage.axis.report().arrival, Arrival::in_position);
  stage.axis.stop();
  stage.cycle();
  EXPECT_EQ(stage.axis.report().arrival, Arrival::not_judged);
}

TEST(AxisExpectation, IsTheLastPositionUntilTheAxisTracksAndThenTheReference) {
  IdealStage stage;
  stage.cycle([](AxisInput& in) { in.position_um = 7.25; });
  EXPECT_EQ(stage.axis.expected_um(0.0), 7.25);
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 25; ++i) stage.cycle();
  const double next_s = stage.time_s + cycle_s;
  const double expected_um = stage.axis.expected_um(next_s);
  stage.cycle();
  EXPECT_EQ(stage.axis.report().reference_um, expected_um) << "in the middle of the transition to 15 um";
}

TEST(AxisExpectation, InOpenLoopIsTheLastPosition) {
  AxisConfig config = support::piezo_axis();
  config.excitation = Excitation::Hysteresis{.low = 10.0, .high = 90.0};
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  EXPECT_EQ(stage.axis.expected_um(stage.time_s), stage.axis.report().position_um);
  EXPECT_EQ(stage.axis.closed_loop(), nullptr);
}

TEST(AxisReference, BeginsWithTheCycleInWhichTheAxisBeginsToTrack) {
  IdealStage stage;
  EXPECT_FALSE(stage.axis.reference_at(stage.time_s)) << "the axis does not track";
  ASSERT_TRUE(stage.tracks());
  const double begin_s = stage.time_s;
  const double first_um = stage.axis.report().reference_um;
  for (int i = 0; i < 25; ++i) stage.cycle();
  EXPECT_FALSE(stage.axis.reference_at(std::nextafter(begin_s, 0.0)));
  ASSERT_TRUE(stage.axis.reference_at(begin_s));
  EXPECT_EQ(stage.axis.reference_at(begin_s)->value_um, first_um);
  EXPECT_EQ(stage.axis.reference_at(stage.time_s)->value_um, stage.axis.report().reference_um);
  EXPECT_GT(stage.axis.report().reference_um, first_um) << "in the middle of the transition to 15 um";
  stage.axis.stop();
  stage.cycle();
  EXPECT_FALSE(stage.axis.reference_at(stage.time_s));
}

TEST(AxisReference, DoesNotExistInOpenLoop) {
  AxisConfig config = support::piezo_axis();
  config.excitation = Excitation::Hysteresis{.low = 10.0, .high = 90.0};
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  EXPECT_FALSE(stage.axis.reference_at(stage.time_s));
}

TEST(AxisExpectation, LooksAheadInClosedLoopByAtLeastTheDelayOfTheCommand) {
  EXPECT_GE(Axis(support::piezo_axis()).closed_loop()->preview_s(cycle_s), 1e-3);
}

}  // namespace
}  // namespace hystcan::controller::axis_bounds_test
