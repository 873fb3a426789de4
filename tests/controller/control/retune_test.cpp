// Changes of the law while it runs: the drive does not jump.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "controller/control/law.h"
#include "tests/support/piezo.h"
#include "tests/support/wiped.h"

namespace hystcan::controller::retune_test {
namespace {

constexpr double dt_s = 1e-3;

ControlLaw::Config config(Structure structure, PiGains pi = {.kp = 0.3, .ki_per_s = 100.0}) {
  return {.structure = structure, .model = support::piezo_model(), .pi = pi};
}

/// Reference and position in cycle n: a sine, and a position that lags and has an error of 3 %.
struct Cycle {
  double reference_um, previewed_um, position_um;
};
Cycle at(double n) {
  const auto r = [](double cycle) { return 15.0 + 9.0 * std::sin(0.02 * cycle); };
  return {r(n), r(n + 2.0), 0.97 * r(n - 1.0) + 0.2};
}

double step(ControlLaw& law, const Cycle& cycle) {
  const auto demand = law.propose({.reference_um = cycle.reference_um,
                                   .previewed_um = cycle.previewed_um,
                                   .position_um = cycle.position_um,
                                   .dt_s = dt_s,
                                   .cycle_s = dt_s});
  law.commit(demand.drive);
  return demand.drive;
}

rc::Gen<ControlLaw::Config> any_config() {
  return rc::gen::apply(
      [](int structure, int kp, int ki, int options) {
        ControlLaw::Config result = config(all_structures[static_cast<std::size_t>(structure)],
                                           {.kp = 0.01 * kp, .ki_per_s = 1.0 * ki});
        if ((options & 1) != 0) result.measurement_filter_Hz = 100.0 + ki;
        if ((options & 2) != 0) result.deadband_um = 0.001 * ki;
        return result;
      },
      rc::gen::inRange(0, 5), rc::gen::inRange(0, 40), rc::gen::inRange(0, 200), rc::gen::inRange(0, 4));
}

// Only the effect of the change: the last cycle is repeated, without elapsed time and without a new sample.
RC_GTEST_PROP(Retune, DoesNotMoveTheDriveForAnyChange, ()) {
  const auto configs = *rc::gen::container<std::vector<ControlLaw::Config>>(6, any_config());
  ControlLaw law(configs[0]);
  for (const double drive : {100.0, 50.0}) law.follow(drive);
  law.restart(at(0.0).position_um);
  double n = 0.0;
  for (std::size_t i = 1; i < configs.size(); ++i) {
    const int cycles = *rc::gen::inRange(1, 100);
    double before = 0.0;
    for (int c = 0; c < cycles; ++c, n += 1.0) before = step(law, at(n));
    law.retune(configs[i]);
    const Cycle last = at(n - 1.0);
    const auto demand = law.propose({.reference_um = last.reference_um,
                                     .previewed_um = last.previewed_um,
                                     .position_um = std::nullopt,
                                     .dt_s = 0.0,
                                     .cycle_s = dt_s});
    RC_ASSERT(std::abs(demand.drive - before) < 1e-6);  // V: rounding of the inverse, end of a fade
    law.commit(demand.drive);
  }
}

TEST(Retune, TheIntegralTakesOverAChangeOfTheProportionalPart) {
  ControlLaw law(config(Structure::inverse_pi));
  support::restart_at_lower_threshold(law, 1.5);
  const Cycle cycle{10.0, 10.0, 9.0};
  step(law, cycle);
  const double integral_um = law.integral_um();
  law.retune(config(Structure::inverse_pi, {.kp = 0.1, .ki_per_s = 100.0}));
  EXPECT_NEAR(law.integral_um(), integral_um + 0.2 * 1.0, 1e-12);
}

TEST(Retune, TheMemoryFollowsTheDriveUnderEveryStructure) {
  const model::Hysteresis stage(support::piezo_model());
  for (const Structure structure : all_structures) {
    ControlLaw law(config(structure, {.kp = 0.3, .ki_per_s = 1.0}));
    support::restart_at_lower_threshold(law, 1.5);
    model::HysteresisState state = stage.at_lower_threshold();
    for (int n = 0; n < 500; ++n) stage.advance(state, step(law, at(n)));
    EXPECT_GT(state.depth(), 1u);
    EXPECT_EQ(law.memory().depth(), state.depth()) << to_string(structure);
    EXPECT_EQ(law.memory().output, state.output) << to_string(structure);
  }
}

TEST(Retune, ARemainingOffsetWithoutFeedbackDecaysWithItsTimeConstant) {
  ControlLaw law(config(Structure::inverse_pi));
  support::restart_at_lower_threshold(law, 4.5);  // 3 um between sensor and model
  const Cycle still{12.0, 12.0, 12.0};
  for (int i = 0; i < 100; ++i) step(law, still);
  const double offset_um = law.predicted_um() - 12.0;
  ASSERT_LT(offset_um, -2.9);
  law.retune(config(Structure::inverse));
  for (int i = 0; i < 100; ++i) step(law, still);
  EXPECT_NEAR(law.predicted_um() - 12.0, offset_um * std::exp(-0.1 / ControlLaw::fade_s), 1e-9);
  for (int i = 0; i < 3000; ++i) step(law, still);
  EXPECT_NEAR(law.predicted_um(), 12.0, 1e-9);
}

// The deadband reduces the error of 1 um to 0.8 um.
TEST(Retune, TheIntegralTakesOverAChangeOfTheDeadband) {
  ControlLaw::Config changed = config(Structure::inverse_pi);
  ControlLaw law(changed);
  support::restart_at_lower_threshold(law, 1.5);
  step(law, {10.0, 10.0, 9.0});
  const double integral_um = law.integral_um();
  changed.deadband_um = 0.2;
  law.retune(changed);
  EXPECT_NEAR(law.integral_um(), integral_um + 0.3 * 0.2, 1e-12);
}

TEST(Retune, MakesTheLawEqualToANewOne) {
  ControlLaw::Config before = config(Structure::inverse_pi, {.kp = 0.3, .ki_per_s = 0.5});
  before.notch = {.frequency_Hz = 0.1};
  std::vector<ControlLaw::Config> changes(4, before);
  changes[0].deadband_um = 0.1;
  changes[1].measurement_filter_Hz = 0.5;
  changes[2].notch = {.frequency_Hz = 0.2};
  changes[3].notch.reset();
  for (const double cycle_s : {dt_s, 1.0})
    for (const ControlLaw::Config& changed : changes) {
      ControlLaw retuned(before), fresh(changed);
      const auto demand_um = [cycle_s](ControlLaw& law, const Cycle& cycle) {
        return law
            .propose({.reference_um = cycle.reference_um,
                      .previewed_um = cycle.previewed_um,
                      .position_um = cycle.position_um,
                      .dt_s = cycle_s,
                      .cycle_s = cycle_s})
            .position_um;
      };
      for (ControlLaw* law : {&retuned, &fresh}) {
        support::restart_at_lower_threshold(*law, 12.0);
        for (int i = 0; i < 3; ++i) demand_um(*law, {12.0, 12.0, 12.0});
      }
      retuned.retune(changed);
      for (int n = 0; n < 20; ++n) EXPECT_NEAR(demand_um(retuned, at(n)), demand_um(fresh, at(n)), 1e-12);
    }
}

TEST(Retune, SeveralStructureChangesInACycleAreBumpless) {
  ControlLaw::Config changed = config(Structure::pi);
  changed.notch = {.frequency_Hz = 100.0, .depth = 0.1, .width = 0.5};
  ControlLaw law(changed);
  support::restart_at_lower_threshold(law, 12.0);
  const Cycle still{12.0, 12.0, 12.0};
  double drive = 0.0;
  for (int i = 0; i < 100; ++i) drive = step(law, {20.0, 20.0, 12.0});
  for (int i = 0; i < 100; ++i) drive = step(law, still);
  for (const Structure structure : {Structure::average_pi, Structure::inverse_pi, Structure::average_pi}) {
    changed.structure = structure;
    law.retune(changed);
  }
  EXPECT_NEAR(step(law, still), drive, 1e-9);
}

// The stage rests at zero, so that the offset is exact: minus the position at the restart.
TEST(Retune, ARemainingOffsetEndsAtATenMillionthOfAMicrometre) {
  for (const double offset_um : {0.9e-7, 1e-7, 1.1e-7, 1.0, -0.9e-7, -1e-7, -1.1e-7, -1.0}) {
    ControlLaw::Config changed = config(Structure::inverse_pi);
    changed.model = support::model_from_zero();
    ControlLaw law(changed);
    support::restart_at_lower_threshold(law, -offset_um);
    changed.structure = Structure::inverse;
    law.retune(changed);
    ASSERT_EQ(law.integral_um(), offset_um);
    step(law, {0.0, 0.0, 0.0});
    const double left = std::abs(offset_um) > 1e-7 ? std::exp(-dt_s / ControlLaw::fade_s) : 0.0;
    EXPECT_DOUBLE_EQ(law.integral_um(), left * offset_um);
  }
}

// A notch may still output its transient, but a change of the notch adds nothing: at rest the drive is
// constant.
TEST(Retune, ANotchIsInsertedChangedAndRemovedAtRestWithoutABump) {
  ControlLaw::Config changed = config(Structure::inverse_pi);
  ControlLaw law(changed);
  support::restart_at_lower_threshold(law, 4.5);
  const Cycle still{12.0, 12.0, 12.0};
  for (int i = 0; i < 5; ++i) step(law, still);
  const double drive = step(law, still);
  for (const double frequency_Hz : {100.0, 300.0, 0.0, 200.0}) {
    changed.notch.reset();
    if (frequency_Hz > 0.0) changed.notch = {.frequency_Hz = frequency_Hz, .depth = 0.0, .width = 0.5};
    changed.structure = frequency_Hz == 300.0 ? Structure::average_pi : Structure::inverse_pi;
    law.retune(changed);
    for (int i = 0; i < 10; ++i) EXPECT_NEAR(step(law, still), drive, 1e-9) << frequency_Hz;
  }
}

TEST(Restart, IsBumplessWithAKnownMemory) {
  const model::Hysteresis stage(support::piezo_model());
  model::HysteresisState known = stage.at_lower_threshold();
  for (const double drive : {80.0, 20.0, 60.0, 33.0}) stage.advance(known, drive);
  for (const Structure structure : all_structures) {
    ControlLaw law(config(structure));
    support::restart_at_lower_threshold(law, 1.5);
    for (int n = 0; n < 50; ++n) step(law, at(n));
    const double measured_um = known.output + 0.7;
    law.remember(known);
    const double reference_um = law.restart(measured_um);
    EXPECT_NEAR(step(law, {reference_um, reference_um, measured_um}), 33.0, 1e-9) << to_string(structure);
    EXPECT_EQ(law.memory().depth(), known.depth());
  }
}

TEST(Restart, FollowsDrivesAppliedWithoutTheLaw) {
  ControlLaw law(config(Structure::inverse_pi));
  for (const double drive : {100.0, 0.0, 70.0, 40.0}) law.follow(drive);
  const double reference_um = law.restart(13.0);
  EXPECT_EQ(reference_um, 13.0);
  EXPECT_NEAR(step(law, {13.0, 13.0, 13.0}), 40.0, 1e-9);
}

TEST(Restart, BeginsWithANotchAtRest) {
  ControlLaw::Config notched = config(Structure::inverse_pi);
  notched.notch = {.frequency_Hz = 100.0, .depth = 0.1, .width = 0.5};
  ControlLaw law(notched);
  for (const double drive : {100.0, 0.0, 70.0, 40.0}) law.follow(drive);
  law.restart(13.0);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(step(law, {13.0, 13.0, 13.0}), 40.0, 1e-9);
}

TEST(MeasurementFilter, CausesNoErrorOnARamp) {
  ControlLaw::Config filtered = config(Structure::inverse_pi);
  filtered.measurement_filter_Hz = 20.0;  // 8 ms of lag: 0.8 um here if only the position were filtered
  ControlLaw law(filtered);
  support::restart_at_lower_threshold(law, 1.5);
  for (int n = 0; n < 200; ++n) {
    const double r = 1.5 + 0.1 * n;
    step(law, {r, r, r});
    EXPECT_NEAR(law.integral_um(), 0.0, 1e-12);
  }
}

TEST(MeasurementFilter, ReducesTheNoiseInTheProportionalPart) {
  ControlLaw::Config filtered = config(Structure::inverse_pi, {.kp = 1.0, .ki_per_s = 0.0});
  filtered.measurement_filter_Hz = 20.0;
  ControlLaw law(filtered);
  support::restart_at_lower_threshold(law, 1.5);
  for (int n = 0; n < 400; ++n) step(law, {10.0, 10.0, n % 2 == 0 ? 10.1 : 9.9});
  EXPECT_NEAR(law.predicted_um(), 10.0, 0.01) << "a sixteenth of 0.1 um of alternating noise remains";
}

TEST(MeasurementFilter, MayHaveACornerBelowOneHertz) {
  ControlLaw::Config filtered = config(Structure::inverse_pi, {.kp = 0.0, .ki_per_s = 100.0});
  filtered.measurement_filter_Hz = 0.5;
  ControlLaw law(filtered);
  support::restart_at_lower_threshold(law, 1.5);
  step(law, {10.0, 10.0, 9.0});
  const double passed = 1.0 - std::exp(-2.0 * std::numbers::pi * 0.5 * dt_s);
  EXPECT_NEAR(law.integral_um(), 100.0 * passed * 1.0 * dt_s, 1e-12);
}

TEST(Deadband, KeepsTheIntegralConstantWithinIt) {
  ControlLaw::Config banded = config(Structure::inverse_pi);
  banded.deadband_um = 0.05;
  ControlLaw law(banded);
  support::restart_at_lower_threshold(law, 1.5);
  for (int n = 0; n < 100; ++n) step(law, {10.0, 10.0, 9.96});
  EXPECT_NEAR(law.integral_um(), 0.0, 1e-12);
  step(law, {10.0, 10.0, 9.85});
  EXPECT_NEAR(law.integral_um(), 100.0 * 0.1 * dt_s, 1e-12);
}

// The sine continues when the cycle time changes; the notch is designed again for the new cycle time.
TEST(Notch, PassesNothingOfItsFrequencyAtAnyCycleTime) {
  ControlLaw::Config notched = config(Structure::inverse);
  notched.notch = {.frequency_Hz = 100.0, .depth = 0.0, .width = 0.5};
  ControlLaw law(notched);
  support::restart_at_lower_threshold(law, 1.5);
  for (const double cycle_s : {dt_s, 2.0 * dt_s}) {
    double demand_um = 0.0;
    for (int n = 0; n < 200; ++n) {
      const double angle = 2.0 * std::numbers::pi * 100.0 * n * cycle_s;
      demand_um = law.propose({.previewed_um = 15.0 + std::cos(angle),
                               .position_um = std::nullopt,
                               .dt_s = cycle_s,
                               .cycle_s = cycle_s})
                      .position_um;
    }
    EXPECT_NEAR(demand_um, 15.0, 1e-9);
  }
}

TEST(Notch, AllowsAntiWindupOfASaturationAfterIt) {
  ControlLaw::Config notched = config(Structure::inverse_pi, {.kp = 0.1, .ki_per_s = 100.0});
  notched.notch = {.frequency_Hz = 100.0, .depth = 0.1, .width = 0.5};
  ControlLaw law(notched);
  support::restart_at_lower_threshold(law, 1.5);
  for (int i = 0; i < 3000; ++i) {
    law.propose(
        {.reference_um = 10.0, .previewed_um = 10.0, .position_um = 4.0, .dt_s = dt_s, .cycle_s = dt_s});
    law.commit(45.0);
  }
  EXPECT_NEAR(law.integral_um(), law.predicted_um() - 10.0, 100.0 * 6.0 * dt_s);
}

}  // namespace
}  // namespace hystcan::controller::retune_test
