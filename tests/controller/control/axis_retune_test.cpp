// An axis retuned while it tracks, and the three ways to begin: what the actuator remembers must be known.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <utility>

#include "tests/controller/control/stage.h"

namespace hystcan::controller {
namespace {

constexpr double steepest_V_per_um = 1.0 / 0.2;  // the flattest branch of the model: 0.2 um/V

AxisConfig tracking_axis() {
  AxisConfig config = support::piezo_axis();
  config.setpoint = {{.shape = Sine{.low_um = 6.0, .high_um = 24.0, .frequency_Hz = 5.0, .cycles = 1.5},
                      .transition_s = 0.05},
                     {.shape = Hold{.level_um = 12.0, .duration_s = 0.1}, .transition_s = 0.05}};
  config.repeat = true;
  config.following_error.error_um = 100.0;  // the average model and pi alone are far off
  config.supervision.frozen_cycles = 0;
  config.supervision.saturated_s = 0.0;
  return config;
}

/// What another version of the file may say.
rc::Gen<AxisConfig> any_tuning() {
  return rc::gen::apply(
      [](std::size_t structure, int kp, int ki, int options) {
        AxisConfig config = tracking_axis();
        config.law.structure = all_structures[structure];
        config.law.pi = {.kp = 0.01 * kp, .ki_per_s = 1.0 * ki};
        if ((options & 1) != 0) config.law.measurement_filter_Hz = 100.0 + ki;
        if ((options & 2) != 0) config.law.deadband_um = 0.001 * ki;
        if ((options & 4) != 0) config.delays.resonance_Hz = 300.0;
        if ((options & 8) != 0)
          config.in_position = {.tolerance_um = 0.1,
                                .window = std::chrono::milliseconds(5),
                                .timeout = std::chrono::milliseconds(100)};
        if ((options & 16) != 0) config.supervision.position_jump_um = 0.0;
        if ((options & 32) != 0) config.wipe_slew_per_s = 500.0;
        return config;
      },
      rc::gen::inRange<std::size_t>(0, 5), rc::gen::inRange(0, 40), rc::gen::inRange(0, 200),
      rc::gen::inRange(0, 64));
}

// The same cycle decided twice, by the axis as it was and by the one retuned. What may differ is what one
// cycle of new gains does to what has moved since the last: reference and stage through P and preview, the
// error through I, an offset of at most 6 um that fades without feedback. At rest that is rounding. What the
// change would do by itself, were it not bumpless, is the whole of P, of the integral, or of the
// feed-forward: 24 um.
RC_GTEST_PROP(AxisRetune, MovesTheDriveNoMoreThanTheReferenceDoes, ()) {
  Stage stage(tracking_axis());
  RC_ASSERT(stage.tracks());
  const std::size_t retunes = *rc::gen::inRange<std::size_t>(1, 8);
  for (std::size_t i = 0; i < retunes; ++i) {
    const int cycles = *rc::gen::inRange(2, 300);
    for (int n = 1; n < cycles; ++n) stage.cycle();
    const AxisReport last = stage.axis.report();
    stage.cycle();
    Axis untouched = stage.axis;
    AxisTuning tuning(*any_tuning(), false);
    RC_ASSERT(stage.axis.retune(tuning).empty());

    const AxisInput input = stage.next_input();
    const double expected = untouched.step(input).drive;
    const double drive = stage.cycle().drive;
    RC_ASSERT(stage.axis.state() == AxisState::tracking);
    const AxisReport& now = stage.axis.report();
    RC_ASSERT(now.reference_um == untouched.report().reference_um);
    const double reference_um = std::abs(now.reference_um - last.reference_um);  // of two cycles
    const double stage_um = std::abs(now.position_um - last.position_um);
    const double error_um = std::abs(now.reference_um - now.position_um);
    const double allowed_um = reference_um + 0.4 * (reference_um + stage_um) + 200.0 * cycle_s * error_um +
                              6.0 * cycle_s / ControlLaw::fade_s;
    RC_ASSERT(std::abs(drive - expected) <= steepest_V_per_um * allowed_um + 1e-6);
  }
}

TEST(AxisRetune, AtRestMovesTheDriveByRoundingOnly) {
  AxisConfig config = tracking_axis();
  config.setpoint = {{.shape = Hold{.level_um = 12.0, .duration_s = 100.0}, .transition_s = 0.05}};
  Stage stage(config);
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 2000; ++i) stage.cycle();
  const double drive = stage.command.drive;
  for (const Structure structure :
       {Structure::average_pi, Structure::pi, Structure::inverse_pi, Structure::average_pi})
    for (const double kp : {0.4, 0.0, 0.1}) {
      config.law.structure = structure;
      config.law.pi.kp = kp;
      AxisTuning tuning(config, false);
      ASSERT_EQ(stage.axis.retune(tuning), "");
      for (int i = 0; i < 20; ++i) ASSERT_NEAR(stage.cycle().drive, drive, 1e-6) << to_string(structure);
    }
}

TEST(AxisRetune, LetsANewReferenceGoOnFromThePresentMotionWhereTheAccelerationIsLimited) {
  Stage stage(tracking_axis());
  ASSERT_TRUE(stage.tracks());
  AxisConfig config = tracking_axis();
  config.reference_limits.acceleration_um_per_s2 = 15'000.0;
  config.setpoint = {{.shape = Hold{.level_um = 20.0, .duration_s = 100.0}, .transition_s = 0.2}};
  for (int i = 0; i < 120; ++i) stage.cycle();
  double before = stage.axis.report().reference_um;
  stage.cycle();
  double step_um = stage.axis.report().reference_um - before;
  ASSERT_GT(std::abs(step_um), 0.1) << "in the middle of a rise";
  AxisTuning tuning(config, true);
  ASSERT_EQ(stage.axis.retune(tuning), "");
  for (int i = 0; i < 300; ++i) {
    before = stage.axis.report().reference_um;
    stage.cycle();
    const double next_um = stage.axis.report().reference_um - before;
    // 15 000 um/s^2 are 0.015 um from cycle to cycle.
    ASSERT_NEAR(next_um, step_um, 0.0151) << i;
    step_um = next_um;
  }
  EXPECT_EQ(stage.axis.report().reference_um, 20.0);
}

TEST(AxisRetune, IsRefusedWholeWhereTheDriveIsOutsideTheNewRange) {
  Stage stage(tracking_axis());
  ASSERT_TRUE(stage.tracks());
  while (stage.command.drive < 70.0) stage.cycle();
  AxisConfig narrow = tracking_axis();
  narrow.gate.drive_max = 60.0;
  narrow.law.pi.kp = 0.4;
  AxisTuning tuning(narrow, true);
  Axis untouched = stage.axis;
  EXPECT_EQ(stage.axis.retune(tuning), "the drive is outside the new drive_min..drive_max now");
  EXPECT_EQ(stage.axis.config().gate.drive_max, 100.0);
  EXPECT_EQ(tuning.config.gate.drive_max, 60.0) << "what was refused stays with the asker";
  for (int i = 0; i < 100; ++i) {
    const AxisInput input = stage.next_input();
    ASSERT_EQ(untouched.step(input).drive, stage.cycle().drive) << "to the bit";
  }
  stage.axis.stop();
  ASSERT_TRUE(stage.reaches(AxisState::offline));
  EXPECT_EQ(stage.axis.retune(tuning), "") << "nothing is driven";
}

TEST(AxisRetune, IsRefusedInOpenLoop) {
  AxisConfig config = support::piezo_axis();
  config.excitation = Excitation::Hysteresis{.low = 20.0, .high = 60.0};
  Stage stage(config);
  AxisTuning tuning(support::piezo_axis(), false);
  EXPECT_EQ(stage.axis.retune(tuning), "the axis runs in open loop");
}

/// Feed-forward alone, and no delay in the stage: at rest only a wrong memory leaves an error. The amplifier
/// rests at `safe_drive` while it is not enabled, between the thresholds, so that nothing is wiped out.
AxisConfig feed_forward_axis(StartUp start_up, double safe_drive = 25.0) {
  AxisConfig config = support::piezo_axis();
  config.gate.safe_drive = safe_drive;
  config.law.structure = Structure::inverse;
  config.start_up = start_up;
  config.following_error.error_um = 100.0;
  config.setpoint = {{.shape = Hold{.level_um = 22.0, .duration_s = 0.1}, .transition_s = 0.1},
                     {.shape = Hold{.level_um = 9.0, .duration_s = 0.1}, .transition_s = 0.1},
                     {.shape = Hold{.level_um = 15.0, .duration_s = 100.0}, .transition_s = 0.1}};
  return config;
}

/// The largest error at the end of each hold.
double error_at_rest_um(Stage& stage) {
  double largest_um = 0.0;
  for (int cycle = 1; cycle <= 700; ++cycle) {
    stage.cycle();
    if (cycle == 195 || cycle == 395 || cycle == 700)
      largest_um = std::max(largest_um, std::abs(stage.axis.report().reference_um - stage.memory().output));
  }
  return largest_um;
}

/// An actuator that came down to its lower threshold and has been driven to 40 V since.
model::HysteresisState risen_stage(const model::Hysteresis& actuator) {
  model::HysteresisState memory = actuator.at_lower_threshold();
  actuator.advance(memory, 40.0);
  return memory;
}

/// One with several loops open.
model::HysteresisState nested_stage(const model::Hysteresis& actuator) {
  model::HysteresisState memory = actuator.at_lower_threshold();
  for (const double drive : {90.0, 10.0, 70.0, 25.0}) actuator.advance(memory, drive);
  return memory;
}

TEST(StartUp, AssumeTracksWithoutAVisitToTheThresholdsWhereItIsTrue) {
  const model::Hysteresis actuator(support::piezo_model());
  Stage stage(feed_forward_axis(StartUp::assume, 40.0), risen_stage(actuator));
  ASSERT_TRUE(stage.tracks());
  EXPECT_NEAR(stage.highest_drive, 40.0, 2.0) << "it stays where it is";
  EXPECT_LT(error_at_rest_um(stage), 1e-6);

  Stage wrong(feed_forward_axis(StartUp::assume), nested_stage(actuator));
  ASSERT_TRUE(wrong.tracks());
  EXPECT_GT(error_at_rest_um(wrong), 0.01) << "ten thousand times the claim above";
}

TEST(StartUp, RestoreTracksOnWithWhatWasSaved) {
  const model::Hysteresis actuator(support::piezo_model());
  const model::HysteresisState memory = nested_stage(actuator);
  Stage stage(feed_forward_axis(StartUp::restore), memory);
  stage.axis.restore(memory, {});
  ASSERT_TRUE(stage.tracks());
  EXPECT_NEAR(stage.highest_drive, 25.0, 2.0);
  EXPECT_LT(error_at_rest_um(stage), 1e-6);
}

TEST(StartUp, WhatIsSavedAtACleanStopIsWhatTheActuatorRemembers) {
  Stage first(feed_forward_axis(StartUp::wipe));
  ASSERT_TRUE(first.tracks());
  EXPECT_EQ(first.axis.law_to_save(), nullptr) << "driven: not at rest yet";
  for (int i = 0; i < 450; ++i) first.cycle();
  first.axis.stop();
  ASSERT_TRUE(first.reaches(AxisState::offline));
  const ControlLaw* law = first.axis.law_to_save();
  ASSERT_NE(law, nullptr);
  EXPECT_NEAR(law->memory().output, first.memory().output, 1e-9);
  EXPECT_EQ(law->memory().depth(), first.memory().depth());

  Stage second(feed_forward_axis(StartUp::restore), first.memory());
  second.axis.restore(law->memory(), law->correction());
  ASSERT_TRUE(second.tracks());
  EXPECT_NEAR(second.highest_drive, 25.0, 2.0);
  EXPECT_LT(error_at_rest_um(second), 1e-6);
}

TEST(StartUp, VisitsTheThresholdsAgainAfterAFaultWhateverIsConfigured) {
  const model::Hysteresis actuator(support::piezo_model());
  for (const StartUp start_up : every<StartUp>()) {
    const model::HysteresisState memory = risen_stage(actuator);
    Stage stage(feed_forward_axis(start_up, 40.0), memory);
    stage.axis.restore(memory, {});
    ASSERT_TRUE(stage.tracks());
    stage.cycle([](AxisInput& in) { in.sensor_status_good = false; });
    ASSERT_EQ(stage.axis.state(), AxisState::faulted);
    EXPECT_EQ(stage.axis.law_to_save(), nullptr);
    ASSERT_TRUE(stage.axis.clear());
    EXPECT_EQ(stage.axis.law_to_save(), nullptr) << "how it came down, nobody knows";
    stage.highest_drive = 0.0;
    ASSERT_TRUE(stage.tracks());
    EXPECT_EQ(stage.highest_drive, 100.0) << word_of(start_up);
    EXPECT_LT(error_at_rest_um(stage), 1e-6) << word_of(start_up);
  }
}

TEST(StartUp, RestoreWithoutASavedMemoryWipes) {
  Stage stage(feed_forward_axis(StartUp::restore));
  ASSERT_TRUE(stage.tracks());
  EXPECT_EQ(stage.highest_drive, 100.0);
}

}  // namespace
}  // namespace hystcan::controller
