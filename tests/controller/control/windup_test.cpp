// The law at each limiter, on a stage that is the model itself with a delay of two cycles.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "controller/control/law.h"
#include "tests/support/piezo.h"
#include "tests/support/wiped.h"

namespace hystcan::controller::windup_test {
namespace {

constexpr double dt_s = 1e-3;
constexpr Gate::Config wide_open{.drive_min = -1e6, .drive_max = 1e6, .slew_per_s = 1e12, .safe_drive = 0.0};

/// Law, gate and stage; the stage's true gain may differ from the model's.
class Loop {
 public:
  Loop(Structure structure, PiGains pi, Gate::Config gate, double true_gain = 1.0)
      : law_({.structure = structure, .model = support::piezo_model(), .pi = pi}),
        gate_(gate),
        true_gain_(true_gain),
        stage_(support::piezo_model()),
        state_(stage_.at_lower_threshold()) {
    positions_um_.fill(true_gain * state_.output);
    support::restart_at_lower_threshold(law_, positions_um_[0]);
  }

  double cycle(double reference_um) { return cycle(reference_um, reference_um); }
  /// Position in this cycle; `previewed_um` is the position that results from the present drive.
  double cycle(double reference_um, double previewed_um) {
    const double position_um = positions_um_[0];
    const auto demand = law_.propose({.reference_um = reference_um,
                                      .previewed_um = previewed_um,
                                      .position_um = position_um,
                                      .dt_s = dt_s});
    const Gate::Passed passed = Gate::step(gate_, drive_, demand.drive, dt_s);
    limits_ = demand.limits | passed.limits;
    drive_ = passed.drive;
    law_.commit(drive_);
    stage_.advance(state_, drive_);
    positions_um_ = {positions_um_[1], true_gain_ * state_.output};
    return position_um;
  }

  ControlLaw& law() { return law_; }
  double drive() const { return drive_; }
  std::uint8_t limits() const { return limits_; }

 private:
  ControlLaw law_;
  Gate::Config gate_;
  double true_gain_;
  model::Hysteresis stage_;
  model::HysteresisState state_;
  std::array<double, 2> positions_um_{};
  double drive_ = 0.0;
  std::uint8_t limits_ = limit::none;
};

/// The overshoot of the position beyond `level_um`, from above or below.
double overshoot_um(Loop& loop, double level_um, int cycles) {
  const double sign = loop.cycle(level_um) < level_um ? 1.0 : -1.0;
  double furthest_um = 0.0;
  for (int i = 0; i < cycles; ++i)
    furthest_um = std::max(furthest_um, sign * (loop.cycle(level_um) - level_um));
  return furthest_um;
}

// Limit, feed-forward and error are constant:
//   I' = ki e - (ki / kp) (F + kp e + I - limit) = 0   at I = limit - F
TEST(Windup, ASaturatedIntegralRestsAtLimitMinusFeedForwardForEveryKp) {
  for (const double kp : {0.0, 0.1, 0.5, 2.0, 8.0}) {
    ControlLaw law({.structure = Structure::inverse_pi,
                    .model = support::piezo_model(),
                    .pi = {.kp = kp, .ki_per_s = 100.0}});
    support::restart_at_lower_threshold(law, 1.5);
    for (int i = 0; i < 2000; ++i) {
      law.propose({.reference_um = 10.0, .previewed_um = 10.0, .position_um = 4.0, .dt_s = dt_s});
      law.commit(45.0);
    }
    const double limit_um = law.predicted_um();
    ASSERT_GT(limit_um, 10.0);
    const double one_cycle_um = 100.0 * 6.0 * dt_s;  // ki e dt: alpha is exact for a continuous loop
    EXPECT_NEAR(law.integral_um(), limit_um - 10.0, one_cycle_um) << kp;
  }
}

// With e = 20 um and kp = 2, P alone demands 40 um beyond the limit. Without kp in the tracking time constant
// (alpha = 1) the integral would end at about -40 um and pull the stage down as soon as P decreases.
TEST(Windup, SaturationByPAloneDoesNotChangeTheIntegralMuch) {
  ControlLaw law({.structure = Structure::inverse_pi,
                  .model = support::piezo_model(),
                  .pi = {.kp = 2.0, .ki_per_s = 100.0}});
  support::restart_at_lower_threshold(law, 1.5);
  for (int i = 0; i < 10; ++i) {
    const auto demand =
        law.propose({.reference_um = 25.0, .previewed_um = 25.0, .position_um = 5.0, .dt_s = dt_s});
    EXPECT_EQ(demand.limits, limit::model);
    law.commit(demand.drive);
  }
  EXPECT_GE(law.integral_um(), -1e-9);
  EXPECT_LE(law.integral_um(), law.predicted_um() - 25.0 + 100.0 * 20.0 * dt_s) << "at most limit - F";
}

TEST(Windup, AnIntegralWithoutGainsIsConstantAtALimit) {
  ControlLaw law(
      {.structure = Structure::pi, .model = support::piezo_model(), .pi = {.kp = 0.0, .ki_per_s = 0.0}});
  support::restart_at_lower_threshold(law, 1.5);
  const double before_um = law.integral_um();
  law.propose({.reference_um = 10.0, .previewed_um = 10.0, .position_um = 4.0, .dt_s = dt_s});
  law.commit(45.0);
  EXPECT_GT(law.predicted_um(), before_um + 5.0) << "far from the demand";
  EXPECT_EQ(law.integral_um(), before_um);
}

/// Returns the integral after one cycle with this error and zero drive. The stage rests at zero, so that the
/// whole demand is excess; the cycle lasts 1 s, so that the sums are exact.
double integral_um_without_drive(PiGains pi, double error_um, double previewed_um = 0.0) {
  ControlLaw law({.structure = Structure::inverse_pi, .model = support::model_from_zero(), .pi = pi});
  support::restart_at_lower_threshold(law, 0.0);
  law.propose({.reference_um = error_um, .previewed_um = previewed_um, .position_um = 0.0, .dt_s = 1.0});
  law.commit(0.0);
  return law.integral_um();
}

TEST(Windup, ADemandMissedByAMillionthOfAMicrometreCountsAsMet) {
  for (const double met_um : {0.9e-6, 1e-6, -0.9e-6, -1e-6})
    EXPECT_EQ(integral_um_without_drive({.kp = 0.0, .ki_per_s = 1.0}, met_um), met_um);
  for (const double missed_um : {1.1e-6, -1.1e-6})
    EXPECT_EQ(integral_um_without_drive({.kp = 0.0, .ki_per_s = 1.0}, missed_um), 0.0);
}

// F equals the realised position: PI has caused the limit.
TEST(Windup, AnIntegralIsReducedByAlphaTimesTheExcess) {
  for (const double ki_per_s : {0.5, 1.0, 100.0})
    for (const double error_um : {1.0, -1.0}) {
      EXPECT_EQ(integral_um_without_drive({.kp = 0.0, .ki_per_s = ki_per_s}, error_um), 0.0) << "alpha = 1";
      const double integral_um = ki_per_s * error_um, excess_um = 2.0 * error_um + integral_um;
      EXPECT_NEAR(integral_um_without_drive({.kp = 2.0, .ki_per_s = ki_per_s}, error_um),
                  integral_um - (1.0 - std::exp(-ki_per_s / 2.0)) * excess_um, 1e-12);
    }
}

TEST(Windup, TheIntegralOnlyLeavesALimitOfTheFeedForward) {
  for (const double sign : {1.0, -1.0}) {
    const PiGains pi{.kp = 0.0, .ki_per_s = 1.0};
    EXPECT_EQ(integral_um_without_drive(pi, sign * 0.25, sign * 0.5), 0.0) << "further into the limit";
    EXPECT_EQ(integral_um_without_drive(pi, -sign * 0.25, sign * 0.5), -sign * 0.25);
  }
}

TEST(Windup, ACycleWithoutASampleDoesNotChangeTheIntegralAtALimit) {
  ControlLaw law(
      {.structure = Structure::pi, .model = support::piezo_model(), .pi = {.kp = 0.0, .ki_per_s = 100.0}});
  support::restart_at_lower_threshold(law, 1.5);
  const double before_um = law.integral_um();
  law.propose({.reference_um = 10.0, .previewed_um = 10.0, .position_um = std::nullopt, .dt_s = dt_s});
  law.commit(45.0);
  EXPECT_GT(law.predicted_um(), before_um + 5.0) << "far from the demand";
  EXPECT_EQ(law.integral_um(), before_um);
}

// The offset of 4 um demands more than the available drive, but the feed-forward does not.
TEST(Windup, ALimitDoesNotChangeAnOffsetThatFadesWithoutFeedback) {
  ControlLaw::Config config{.structure = Structure::inverse_pi,
                            .model = support::model_from_zero(),
                            .pi = {.kp = 0.0, .ki_per_s = 1.0}};
  ControlLaw law(config);
  support::restart_at_lower_threshold(law, -4.0);
  config.structure = Structure::inverse;
  law.retune(config);
  law.propose({.reference_um = 0.0, .previewed_um = -1.0, .position_um = 0.0, .dt_s = dt_s});
  law.commit(0.0);
  EXPECT_DOUBLE_EQ(law.integral_um(), 4.0 * std::exp(-dt_s / ControlLaw::fade_s));
}

// With structure pi, the integral provides the whole stroke: 40 um is out of reach, 20 um is not. Without
// anti-windup, half a second at 60 / s and 10 um is 300 um of integral, which needs the same time to decay.
TEST(Windup, SaturationOfTheModelCausesNoMoreOvershootThanTheLinearLoop) {
  const PiGains pi{.kp = 0.2, .ki_per_s = 60.0};
  Loop linear(Structure::pi, pi, wide_open), saturated(Structure::pi, pi, wide_open);
  for (int i = 0; i < 500; ++i) {
    linear.cycle(29.0);
    saturated.cycle(40.0);
  }
  EXPECT_EQ(saturated.limits(), limit::model);
  EXPECT_LE(overshoot_um(saturated, 20.0, 100), overshoot_um(linear, 20.0, 100) + 0.05);
  EXPECT_NEAR(saturated.cycle(20.0), 20.0, 0.1) << "100 cycles are six time constants of the linear loop";
}

TEST(Windup, TheSlewOfTheGateCausesNoMoreOvershootThanTheLinearLoop) {
  const PiGains pi{.kp = 0.2, .ki_per_s = 60.0};
  Gate::Config slow = wide_open;
  slow.slew_per_s = 500.0;  // the step response of the linear loop needs about 8000 V/s
  Loop linear(Structure::pi, pi, wide_open), limited(Structure::pi, pi, slow);
  bool was_limited = false;
  const double of_linear_um = overshoot_um(linear, 25.0, 800);
  double of_limited_um = 0.0;
  for (int i = 0; i < 800; ++i) {
    of_limited_um = std::max(of_limited_um, limited.cycle(25.0) - 25.0);
    was_limited = was_limited || limited.limits() == limit::slew;
  }
  EXPECT_TRUE(was_limited);
  EXPECT_LE(of_limited_um, of_linear_um + 0.05);
}

// The reference itself is out of reach for some time. The integral keeps its correction of the stage (here
// 3 %).
TEST(Windup, AReferenceOutOfReachDoesNotChangeTheIntegral) {
  Gate::Config narrow = wide_open;
  narrow.drive_max = 70.0;
  Loop loop(Structure::inverse_pi, {.kp = 0.05, .ki_per_s = 120.0}, narrow, 0.97);
  for (int i = 0; i < 300; ++i) loop.cycle(15.0);
  const double known_um = loop.law().integral_um();
  ASSERT_GT(known_um, 0.3);
  for (int i = 0; i < 300; ++i) loop.cycle(27.0);
  ASSERT_EQ(loop.limits(), limit::range);
  EXPECT_NEAR(loop.law().integral_um(), known_um, 0.15);
}

// A step of the reference under inverse+pi: the slew limit delays the feed-forward. The integral must neither
// compensate this delay afterwards nor cancel the feed-forward.
TEST(Windup, ASlewLimitedStepArrivesWithoutATailOfTheIntegral) {
  Gate::Config slow = wide_open;
  slow.slew_per_s = 5000.0;
  Loop loop(Structure::inverse_pi, {.kp = 0.05, .ki_per_s = 120.0}, slow);
  int arrived = 0;
  double furthest_um = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double position_um = loop.cycle(20.0);
    if (std::abs(position_um - 20.0) > 0.5) arrived = i;
    furthest_um = std::max(furthest_um, position_um);
  }
  // 20 um is 73 V: 15 cycles at 5000 V/s, and 2 cycles of delay.
  EXPECT_LE(arrived, 20);
  EXPECT_LE(furthest_um, 20.7);
}

}  // namespace
}  // namespace hystcan::controller::windup_test
