// Retuning of a tracking axis, and the three kinds of start-up, which provide the actuator's memory.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

#include "tests/controller/control/ideal_stage.h"

namespace hystcan::controller::axis_retune_test {
namespace {

constexpr double steepest_V_per_um = 1.0 / 0.2;  // the flattest branch of the model: 0.2 um/V

AxisConfig tracking_axis() {
  AxisConfig config = support::piezo_axis();
  config.setpoint = {{.shape = Sine{.low_um = 6.0, .high_um = 24.0, .frequency_Hz = 5.0, .cycles = 1.5},
                      .transition_s = 0.05},
                     {.shape = Hold{.level_um = 12.0, .duration_s = 0.1}, .transition_s = 0.05}};
  config.repeat = true;
  config.following_error.error_um = 100.0;  // the average model and pi alone have large errors
  config.supervision.frozen_cycles = 0;
  config.supervision.saturated_s = 0.0;
  return config;
}

/// Returns another valid version of the configuration.
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

// The former axis and the retuned axis decide the same cycle. They may differ only by the effect of one cycle
// of new gains on the changes since the last cycle: reference and stage through P and preview, the error
// through I, and an offset of at most 6 um that fades without feedback. At rest this is rounding. A change
// with a bump would add the whole of P, of the integral, or of the feed-forward: 24 um.
RC_GTEST_PROP(AxisRetune, MovesTheDriveNoMoreThanTheReferenceDoes, ()) {
  IdealStage stage(tracking_axis());
  RC_ASSERT(stage.tracks());
  const std::size_t retunes = *rc::gen::inRange<std::size_t>(1, 8);
  for (std::size_t i = 0; i < retunes; ++i) {
    const int cycles = *rc::gen::inRange(2, 300);
    for (int n = 1; n < cycles; ++n) stage.cycle();
    const AxisReport last = stage.axis.report();
    stage.cycle();
    Axis untouched = stage.axis;
    AxisTuning tuning(*any_tuning(), false);
    RC_ASSERT(!stage.axis.retune(tuning));

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

TEST(AxisRetune, ContinuesThePresentMotionWithLimitedAcceleration) {
  IdealStage stage(tracking_axis());
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
  ASSERT_EQ(stage.axis.retune(tuning), std::nullopt);
  for (int i = 0; i < 300; ++i) {
    before = stage.axis.report().reference_um;
    stage.cycle();
    const double next_um = stage.axis.report().reference_um - before;
    // 15 000 um/s^2 is 0.015 um from cycle to cycle.
    ASSERT_NEAR(next_um, step_um, 0.0151) << i;
    step_um = next_um;
  }
  EXPECT_EQ(stage.axis.report().reference_um, 20.0);
}

// Half of 20 000 V/s at 0.285 um/V; a thousandth of 28.5 um, the lag of a mode of 500 Hz.
TEST(TransitionLimits, AreByDefaultThoseOfTheDrivesSlewAndTheMode) {
  const AxisConfig axis = support::piezo_axis();
  const ReferenceLimits limits = default_transition_limits(axis.gate, axis.law.model, axis.delays);
  EXPECT_NEAR(limits.slew_um_per_s, 2850.0, 1e-9);
  EXPECT_NEAR(limits.acceleration_um_per_s2, 281'283.7, 1.0);
}

TEST(AxisRetune, DoesNotIncreaseTheDriveStepsWithLimitedTransitions) {
  AxisConfig config = tracking_axis();
  config.transition_limits = default_transition_limits(config.gate, config.law.model, config.delays);
  IdealStage undisturbed(config);
  ASSERT_TRUE(undisturbed.tracks());
  double own_V = 0.0;
  for (int i = 0; i < 700; ++i) {
    const double before = undisturbed.command.drive;
    own_V = std::max(own_V, std::abs(undisturbed.cycle().drive - before));
  }
  AxisConfig next = config;
  next.setpoint = {{.shape = Hold{.level_um = 20.0, .duration_s = 100.0}, .transition_s = 0.2}};
  for (int phase = 0; phase < 700; phase += 7) {
    IdealStage stage(config);
    ASSERT_TRUE(stage.tracks());
    for (int i = 0; i < phase; ++i) stage.cycle();
    AxisTuning tuning(next, true);
    ASSERT_EQ(stage.axis.retune(tuning), std::nullopt);
    for (int i = 0; i < 50; ++i) {
      const double before = stage.command.drive;
      ASSERT_LE(std::abs(stage.cycle().drive - before), 1.05 * own_V) << phase << " + " << i;
    }
  }
}

TEST(AxisRetune, ChangesNothingIfTheDriveIsOutsideTheNewRange) {
  IdealStage stage(tracking_axis());
  ASSERT_TRUE(stage.tracks());
  while (stage.command.drive < 70.0) stage.cycle();
  AxisConfig narrow = tracking_axis();
  narrow.gate.drive_max = 60.0;
  narrow.law.pi.kp = 0.4;
  AxisTuning tuning(narrow, true);
  Axis untouched = stage.axis;
  EXPECT_EQ(stage.axis.retune(tuning), Refusal::drive_out_of_range);
  EXPECT_EQ(stage.axis.config().gate.drive_max, 100.0);
  EXPECT_EQ(tuning.config.gate.drive_max, 60.0) << "a refused tuning is unchanged";
  for (int i = 0; i < 100; ++i) {
    const AxisInput input = stage.next_input();
    ASSERT_EQ(untouched.step(input).drive, stage.cycle().drive) << "to the bit";
  }
  stage.axis.stop();
  ASSERT_TRUE(stage.reaches(AxisState::offline));
  EXPECT_EQ(stage.axis.retune(tuning), std::nullopt) << "the axis is not driven";
}

TEST(AxisRetune, IsAcceptedIfTheDriveIsAtABoundOfTheNewRange) {
  const AxisConfig config = support::piezo_axis();
  IdealStage stage(config);
  stage.axis.start(false);
  while (stage.command.drive < 100.0) stage.cycle();
  AxisTuning at_the_upper(config, false);
  EXPECT_EQ(stage.axis.retune(at_the_upper), std::nullopt);
  ASSERT_TRUE(stage.reaches(AxisState::ready));
  ASSERT_EQ(stage.command.drive, 0.0);
  AxisTuning at_the_lower(config, false);
  EXPECT_EQ(stage.axis.retune(at_the_lower), std::nullopt);
}

TEST(AxisRetune, IsRefusedIfTheDriveIsBelowTheNewRange) {
  AxisConfig config = support::piezo_axis();
  IdealStage stage(config);
  stage.axis.start(false);
  ASSERT_TRUE(stage.reaches(AxisState::ready));
  config.gate.drive_min = 1.0;
  AxisTuning tuning(config, false);
  EXPECT_EQ(stage.axis.retune(tuning), Refusal::drive_out_of_range);
}

TEST(AxisRetune, ChangesTheSupervision) {
  AxisConfig config = support::piezo_axis();
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  config.supervision.missing_samples = 6;
  AxisTuning tuning(config, false);
  ASSERT_EQ(stage.axis.retune(tuning), std::nullopt);
  const auto lost = [](AxisInput& in) { in.position_um.reset(); };
  for (int i = 0; i < 6; ++i) EXPECT_TRUE(stage.cycle(lost).enable) << i;
  EXPECT_FALSE(stage.cycle(lost).enable);
}

TEST(AxisRetune, StartsLearning) {
  IdealStage stage(tracking_axis());
  ASSERT_TRUE(stage.tracks());
  ASSERT_EQ(stage.axis.closed_loop()->learning(), nullptr);
  AxisConfig config = tracking_axis();
  config.learning = {.rate = 0.5, .correction_max_um = 1.0};
  config.learning->plans = {{.phases = 200, .cycle_s = cycle_s, .taps = {1.0}, .duration_s = 0.3}, {}};
  AxisTuning tuning(config, false);
  ASSERT_EQ(stage.axis.retune(tuning), std::nullopt);
  EXPECT_NE(stage.axis.closed_loop()->learning(), nullptr);
}

/// Expects no fault within 200 cycles with the first configuration, and this fault after the retune.
void expect_fault_only_after_retune(const AxisConfig& first, const AxisConfig& later, Cause cause,
                                    bool tracks, const std::function<void(AxisInput&)>& disturb) {
  for (const bool retuned : {false, true}) {
    IdealStage stage(first);
    ASSERT_EQ(tracks && stage.tracks(), tracks);
    AxisTuning tuning(later, false);
    ASSERT_FALSE(retuned && stage.axis.retune(tuning));
    if (!tracks) stage.axis.start(false);
    for (int i = 0; i < 200; ++i) stage.cycle(disturb);
    EXPECT_EQ(stage.axis.fault().cause, retuned ? cause : Cause::none);
  }
}

// With a mode of 1 Hz, the stage may ring by more than the whole ramp at its corners.
TEST(AxisRetune, ChangesTheRampCheckOfTheNextStart) {
  AxisConfig first = tracking_axis(), later = first;
  first.supervision.position_min_um = later.supervision.position_min_um = -40.0;
  first.delays.resonance_Hz = 1.0;
  expect_fault_only_after_retune(first, later, Cause::position_contradicts, false,
                                 [](AxisInput& in) { in.position_um = -*in.position_um; });
}

// Five percent of the drive range.
TEST(AxisRetune, ChangesTheToleranceOfTheOutputCheck) {
  AxisConfig first = support::piezo_axis();
  AxisConfig later = first;
  first.gate.drive_max = 400.0;
  expect_fault_only_after_retune(first, later, Cause::output_differs, true, [](AxisInput& in) {
    in.health.output_reported = true;
    in.health.amplifier_output += 10.0;
  });
}

TEST(AxisRetune, StillDetectsAWrongOutput) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  AxisTuning tuning(stage.axis.config(), false);
  ASSERT_FALSE(stage.axis.retune(tuning));
  for (int i = 0; i < 60; ++i)
    stage.cycle([](AxisInput& in) {
      in.health.output_reported = true;
      in.health.amplifier_output -= 20.0;
    });
  EXPECT_EQ(stage.axis.fault().cause, Cause::output_differs);
}

TEST(AxisRetune, ChangesTheOscillationThatMeansAnUnstableLoop) {
  AxisConfig first = tracking_axis();
  first.supervision.position_jump_um = 0.0;
  first.supervision.position_min_um = -1000.0;
  AxisConfig later = first;
  later.supervision.position_min_um = -70.0;
  int cycle = 0;
  expect_fault_only_after_retune(first, later, Cause::loop_unstable, true, [&](AxisInput& in) {
    *in.position_um += ++cycle / 4 % 2 == 0 ? 6.0 : -6.0;
  });
}

TEST(AxisRetune, IsRefusedInOpenLoop) {
  IdealStage stage(support::excited_piezo(Excitation::Hysteresis{.low = 20.0, .high = 60.0}));
  AxisTuning tuning(support::piezo_axis(), false);
  EXPECT_EQ(stage.axis.retune(tuning), Refusal::open_loop);
}

/// Feed-forward alone, and a stage without delay: at rest only a wrong memory causes an error. While the
/// amplifier is not enabled, it rests at `safe_drive`, between the thresholds, so that no memory is wiped
/// out.
AxisConfig feed_forward_axis(MemorySource start_up, double safe_drive = 25.0) {
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

/// Returns the largest error at the end of each hold.
double error_at_rest_um(IdealStage& stage) {
  double largest_um = 0.0;
  for (int cycle = 1; cycle <= 700; ++cycle) {
    stage.cycle();
    if (cycle == 195 || cycle == 395 || cycle == 700)
      largest_um = std::max(largest_um, std::abs(stage.axis.report().reference_um - stage.memory().output));
  }
  return largest_um;
}

/// An actuator driven from its lower threshold to 40 V.
model::HysteresisState risen_stage(const model::Hysteresis& actuator) {
  model::HysteresisState memory = actuator.at_lower_threshold();
  actuator.advance(memory, 40.0);
  return memory;
}

/// An actuator with several open loops.
model::HysteresisState nested_stage(const model::Hysteresis& actuator) {
  model::HysteresisState memory = actuator.at_lower_threshold();
  for (const double drive : {90.0, 10.0, 70.0, 25.0}) actuator.advance(memory, drive);
  return memory;
}

TEST(StartUp, AssumeTracksWithoutARampIfItsAssumptionIsTrue) {
  const model::Hysteresis actuator(support::piezo_model());
  IdealStage stage(feed_forward_axis(MemorySource::assume, 40.0), risen_stage(actuator));
  ASSERT_TRUE(stage.tracks());
  EXPECT_NEAR(stage.highest_drive, 40.0, 2.0) << "the drive stays where it is";
  EXPECT_LT(error_at_rest_um(stage), 1e-6);

  IdealStage wrong(feed_forward_axis(MemorySource::assume), nested_stage(actuator));
  ASSERT_TRUE(wrong.tracks());
  EXPECT_GT(error_at_rest_um(wrong), 0.01) << "ten thousand times the bound above";
}

TEST(StartUp, RestoreTracksWithTheSavedMemory) {
  const model::Hysteresis actuator(support::piezo_model());
  const model::HysteresisState memory = nested_stage(actuator);
  IdealStage stage(feed_forward_axis(MemorySource::restore), memory);
  stage.axis.restore(memory);
  ASSERT_TRUE(stage.tracks());
  EXPECT_NEAR(stage.highest_drive, 25.0, 2.0);
  EXPECT_LT(error_at_rest_um(stage), 1e-6);
}

TEST(StartUp, ACleanStopSavesTheMemoryOfTheActuator) {
  IdealStage first(feed_forward_axis(MemorySource::wipe));
  ASSERT_TRUE(first.tracks());
  EXPECT_EQ(first.axis.law_to_save(), nullptr) << "the axis is still driven";
  for (int i = 0; i < 450; ++i) first.cycle();
  first.axis.stop();
  ASSERT_TRUE(first.reaches(AxisState::offline));
  const ControlLaw* law = first.axis.law_to_save();
  ASSERT_NE(law, nullptr);
  EXPECT_NEAR(law->memory().output, first.memory().output, 1e-9);
  EXPECT_EQ(law->memory().depth(), first.memory().depth());

  IdealStage second(feed_forward_axis(MemorySource::restore), first.memory());
  second.axis.restore(law->memory());
  ASSERT_TRUE(second.tracks());
  EXPECT_NEAR(second.highest_drive, 25.0, 2.0);
  EXPECT_LT(error_at_rest_um(second), 1e-6);
}

TEST(StartUp, VisitsTheThresholdsAfterAFaultInEveryMode) {
  const model::Hysteresis actuator(support::piezo_model());
  for (const MemorySource start_up : every<MemorySource>()) {
    const model::HysteresisState memory = risen_stage(actuator);
    IdealStage stage(feed_forward_axis(start_up, 40.0), memory);
    stage.axis.restore(memory);
    ASSERT_TRUE(stage.tracks());
    stage.cycle([](AxisInput& in) { in.sensor_status_good = false; });
    ASSERT_EQ(stage.axis.state(), AxisState::faulted);
    EXPECT_EQ(stage.axis.law_to_save(), nullptr);
    ASSERT_EQ(stage.axis.clear(), std::nullopt);
    EXPECT_EQ(stage.axis.law_to_save(), nullptr) << "the path to the safe drive is unknown";
    stage.highest_drive = 0.0;
    ASSERT_TRUE(stage.tracks());
    EXPECT_EQ(stage.highest_drive, 100.0) << word_of(start_up);
    EXPECT_LT(error_at_rest_um(stage), 1e-6) << word_of(start_up);
  }
}

TEST(StartUp, RestoreWithoutASavedMemoryWipes) {
  IdealStage stage(feed_forward_axis(MemorySource::restore));
  ASSERT_TRUE(stage.tracks());
  EXPECT_EQ(stage.highest_drive, 100.0);
}

}  // namespace
}  // namespace hystcan::controller::axis_retune_test
