#include "controller/control/adaptation.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "controller/control/law.h"
#include "tests/support/piezo.h"
#include "tests/support/wiped.h"

namespace hystcan::controller::adaptation_test {
namespace {

constexpr double dt_s = 1e-3;
constexpr Adaptation::Config slow{.gain_max = 0.1, .offset_max_um = 1.0, .time_constant_s = 1.0};
constexpr model::Interval range_um{1.5, 30.0};
constexpr double middle_um = 15.75;

ControlLaw adaptive(std::optional<Adaptation::Config> adaptation) {
  ControlLaw::Config config{.structure = Structure::inverse_pi,
                            .model = support::piezo_model(),
                            .pi = {.kp = 0.05, .ki_per_s = 120.0}};
  config.adaptation = adaptation;
  ControlLaw law(config);
  support::restart_at_lower_threshold(law, 1.5);
  return law;
}

/// Tracks a slow sine on a stage that is `gain` times the model plus an offset. Returns the largest error of
/// the last half second.
double track(ControlLaw& law, double gain, double offset_um, double seconds, bool steady = true) {
  const model::Hysteresis stage(support::piezo_model());
  model::HysteresisState state = stage.at_lower_threshold();
  double worst_um = 0.0;
  for (int n = 0; n < static_cast<int>(seconds / dt_s); ++n) {
    const double reference_um = 15.0 - 9.0 * std::cos(2.0 * std::numbers::pi * 5.0 * n * dt_s);
    const double position_um = gain * state.output + offset_um;
    const auto demand =
        law.propose({.reference_um = reference_um,
                     .previewed_um = 15.0 - 9.0 * std::cos(2.0 * std::numbers::pi * 5.0 * (n + 1) * dt_s),
                     .position_um = position_um,
                     .dt_s = dt_s,
                     .cycle_s = dt_s,
                     .steady = steady});
    law.commit(demand.drive);
    stage.advance(state, demand.drive);
    if (n * dt_s > seconds - 0.5) worst_um = std::max(worst_um, std::abs(reference_um - position_um));
  }
  return worst_um;
}

TEST(Adaptation, LearnsTheGainAndOffsetOfTheStage) {
  ControlLaw law = adaptive(slow);
  track(law, 1.04, -0.3, 60.0);
  EXPECT_NEAR(law.correction().gain, 1.04, 0.002);
  EXPECT_NEAR(law.correction().offset_um, -0.3, 0.03);
}

TEST(Adaptation, ReducesTheErrorThatPiAloneLeaves) {
  ControlLaw learning = adaptive(slow), fixed = adaptive(std::nullopt);
  EXPECT_LT(track(learning, 1.04, -0.3, 30.0), 0.2 * track(fixed, 1.04, -0.3, 30.0));
}

TEST(Adaptation, StaysWithinItsBoundsOnAStageThatDiffersMuchFromTheModel) {
  ControlLaw law = adaptive(slow);
  track(law, 0.7, 3.0, 20.0);
  EXPECT_DOUBLE_EQ(law.correction().gain, 0.9);
  EXPECT_LE(std::abs(law.correction().offset_um + (law.correction().gain - 1.0) * middle_um), 1.0 + 1e-9);
}

TEST(Adaptation, IsFrozenInTransitionsAndWhereTheDriveIsLimited) {
  ControlLaw law = adaptive(slow);
  track(law, 1.04, -0.3, 1.0, false);
  EXPECT_EQ(law.correction().gain, 1.0);
  for (int n = 0; n < 1000; ++n) {
    law.propose(
        {.reference_um = 20.0, .previewed_um = 20.0, .position_um = 15.0, .dt_s = dt_s, .steady = true});
    law.commit(30.0);
  }
  EXPECT_EQ(law.correction().gain, 1.0);
  EXPECT_EQ(law.correction().offset_um, 0.0);
}

// The integral gives up what the correction takes over.
TEST(Adaptation, IsSetAndRevertedWithoutABumpInTheDrive) {
  ControlLaw law = adaptive(slow);
  const ControlLaw::Input still{
      .reference_um = 12.0, .previewed_um = 12.0, .position_um = 12.0, .dt_s = dt_s};
  double drive = 0.0;
  for (int n = 0; n < 10; ++n) {
    drive = law.propose(still).drive;
    law.commit(drive);
  }
  for (const ModelCorrection correction :
       {ModelCorrection{1.05, 0.2}, ModelCorrection{}, ModelCorrection{0.95, -0.5}}) {
    law.set_correction(correction);
    EXPECT_NEAR(law.correction().gain, correction.gain, 1e-12);
    EXPECT_NEAR(law.propose(still).drive, drive, 1e-9);
    law.commit(drive);
  }
}

TEST(Adaptation, IsTheIdentityWhereItIsNotConfigured) {
  ControlLaw law = adaptive(std::nullopt);
  law.set_correction({1.05, 0.2});
  track(law, 1.04, -0.3, 2.0);
  EXPECT_EQ(law.correction().gain, 1.0);
  EXPECT_EQ(law.correction().offset_um, 0.0);
}

// The two results of the proof, for any correction within the bounds, any integral, any position.
RC_GTEST_PROP(Adaptation, StepStaysWithinTheBoundsAndNeverInvertsOrRaisesTheIntegral, ()) {
  const auto part = [] { return *rc::gen::inRange(-1000, 1001) * 1e-3; };
  const double gain = 1.0 + slow.gain_max * part();
  const ModelCorrection before{.gain = gain,
                               .offset_um = slow.offset_max_um * part() - (gain - 1.0) * middle_um};
  const double integral_um = 50.0 * part(), modelled_um = middle_um + 14.25 * part();
  const double step_s = *rc::gen::elementOf(std::vector<double>{1e-4, 1e-3, 0.1, 10.0});
  const ModelCorrection after = Adaptation::step(slow, before, range_um, modelled_um, integral_um, step_s);
  RC_ASSERT(std::abs(after.gain - 1.0) <= slow.gain_max + 1e-12);
  RC_ASSERT(std::abs(after.offset_um + (after.gain - 1.0) * middle_um) <= slow.offset_max_um + 1e-9);
  const double left_um = integral_um + after.apply(modelled_um) - before.apply(modelled_um);
  RC_ASSERT(left_um * integral_um >= -1e-9);
  RC_ASSERT(std::abs(left_um) <= std::abs(integral_um) + 1e-9);
}

}  // namespace
}  // namespace hystcan::controller::adaptation_test
