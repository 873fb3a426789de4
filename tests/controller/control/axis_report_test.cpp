// The report of an axis, the position that it expects next, and its reference.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/controller/control/ideal_stage.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::axis_report_test {
namespace {

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

TEST(AxisReportTest, ReportsAMissingSampleInEachCycle) {
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

TEST(AxisReportTest, KeepsTheLastPositionIfTheSampleIsMissing) {
  IdealStage stage;
  stage.cycle([](AxisInput& in) { in.position_um = 7.25; });
  stage.cycle([](AxisInput& in) { in.position_um.reset(); });
  EXPECT_EQ(stage.axis.report().position_um, 7.25);
}

TEST(AxisReportTest, HasTheLimitsOfThisCycleAlone) {
  AxisConfig config =
      support::excited_piezo(Excitation::Steps{.centre = 50.0, .amplitude = 20.0, .period_s = 0.2});
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

TEST(AxisExpectation, IsTheLastPositionInOpenLoop) {
  IdealStage stage(support::excited_piezo(Excitation::Hysteresis{.low = 10.0, .high = 90.0}));
  ASSERT_TRUE(stage.tracks());
  EXPECT_EQ(stage.axis.expected_um(stage.time_s), stage.axis.report().position_um);
  EXPECT_EQ(stage.axis.closed_loop(), nullptr);
}

TEST(AxisExpectation, LooksAheadInClosedLoopByAtLeastTheDelayOfTheCommand) {
  EXPECT_GE(Axis(support::piezo_axis()).closed_loop()->preview_s(cycle_s), 1e-3);
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
  IdealStage stage(support::excited_piezo(Excitation::Hysteresis{.low = 10.0, .high = 90.0}));
  ASSERT_TRUE(stage.tracks());
  EXPECT_FALSE(stage.axis.reference_at(stage.time_s));
}

}  // namespace
}  // namespace hystcan::controller::axis_report_test
