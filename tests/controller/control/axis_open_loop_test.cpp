// An axis in open loop: the drive comes from an excitation, and the position is only supervised.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "tests/controller/control/ideal_stage.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::axis_open_loop_test {
namespace {

TEST(AxisInOpenLoop, RampsStraightToTheFirstDriveAndNotToTheModelsThresholds) {
  IdealStage stage(support::excited_piezo(Excitation::Hysteresis{.low = 20.0, .high = 60.0}));
  stage.axis.start(false);
  double before = 0.0;
  while (stage.axis.state() != AxisState::tracking) {
    stage.cycle();
    ASSERT_LE(stage.command.drive, before + 1000.0 * cycle_s * (1 + 1e-12)) << "wipe_slew_per_s";
    before = stage.command.drive;
  }
  EXPECT_EQ(stage.highest_drive, 20.0);
}

TEST(AxisInOpenLoop, AppliesTheExcitationAtAnyPosition) {
  const Excitation::Chirp chirp{.centre = 40.0, .amplitude = 10.0, .to_Hz = 100.0, .duration_s = 1.0};
  AxisConfig config = support::excited_piezo(chirp);
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
  IdealStage stage(support::excited_piezo(
      Excitation::Chirp{.centre = 40.0, .amplitude = 10.0, .to_Hz = 100.0, .duration_s = 1.0}));
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
  IdealStage stage(support::excited_piezo(Excitation::Hysteresis{.slew_per_s = 100.0, .rest_s = 0.0}));
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 100; ++i) stage.cycle();
  const double before = stage.command.drive;
  stage.cycle([](AxisInput& in) { in.position_um.reset(); });
  EXPECT_TRUE(stage.axis.report().sample_missing);
  EXPECT_NEAR(stage.command.drive, before + 100.0 * cycle_s, 1e-9);
}

TEST(AxisInOpenLoop, LimitsASteepStepToTheSlewOfTheGate) {
  AxisConfig config =
      support::excited_piezo(Excitation::Steps{.centre = 50.0, .amplitude = 20.0, .period_s = 0.2});
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

TEST(AxisInOpenLoop, RefusesAnExcitationBeyondTheGate) {
  for (const Excitation::Config& excitation :
       {Excitation::Config(Excitation::Hysteresis{.low = -1.0, .high = 100.0}),
        Excitation::Config(Excitation::Hysteresis{.low = 0.0, .high = 101.0}),
        Excitation::Config(Excitation::Hysteresis{.slew_per_s = 20'001.0}),
        Excitation::Config(Excitation::Steps{.centre = 98.0, .amplitude = 5.0}),
        Excitation::Config(Excitation::Chirp{.centre = 2.0, .amplitude = 5.0}),
        Excitation::Config(Excitation::Chirp{.amplitude = 10.0, .to_Hz = 400.0})})
    EXPECT_THROW(Axis(support::excited_piezo(excitation)), std::invalid_argument);
}

TEST(AxisInOpenLoop, RampsDownAtAStopInTheMiddleOfTheExcitation) {
  IdealStage stage(support::excited_piezo(Excitation::Hysteresis{.slew_per_s = 200.0}));
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
}  // namespace hystcan::controller::axis_open_loop_test
