#include "controller/control/axis.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/controller/control/ideal_stage.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::axis_test {
namespace {

TEST(Axis, DrivesNothingBeforeItIsStarted) {
  IdealStage stage;
  EXPECT_FALSE(stage.cycle().enable);
  EXPECT_EQ(stage.axis.state(), AxisState::offline);
}

TEST(Axis, WaitsForEachMissingConditionAndReportsIt) {
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

TEST(Axis, TracksToTheInversesPrecisionAfterTheMemoryIsWipedOut) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  EXPECT_NEAR(stage.axis.report().position_um, 15.0, 1e-9);
  EXPECT_EQ(stage.axis.report().limits, limit::none);
}

TEST(Axis, StopsWithoutARampWhileItIsWaiting) {
  IdealStage stage;
  stage.axis.start(false);
  stage.axis.stop();
  EXPECT_FALSE(stage.cycle().enable);
  EXPECT_EQ(stage.axis.state(), AxisState::offline);
}

TEST(Axis, BridgesSingleLossesButTripsIfHalfTheSamplesAreLost) {
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

// The drive rests, so the model predicts no motion of the position.
TEST(Axis, RejectsASecondJumpIfItsDriveHasRested) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  for (int i = 0; i < 4; ++i) stage.cycle([](AxisInput& in) { in.position_um = 7.0; });
  EXPECT_EQ(stage.axis.fault().cause, Cause::position_jumped);
}

TEST(Axis, RestartsTheOscillationCheckAtAStart) {
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
  ASSERT_EQ(stage.axis.clear(), std::nullopt);
  ASSERT_TRUE(stage.tracks());
  EXPECT_EQ(oscillate(10), Cause::none);
}

TEST(Axis, TripsIfItsDriveIsLimitedForTooLong) {
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

}  // namespace
}  // namespace hystcan::controller::axis_test
