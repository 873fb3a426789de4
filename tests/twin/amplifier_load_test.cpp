// The amplifier at the limits of its load, compared with closed forms and a fine numerical integration.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "twin/amplifier.h"

namespace hystcan::twin::amplifier_load_test {
namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;

/// 10 V across 10 mH and 2 ohm: at most 5 A, with a time constant of 5 ms.
Amplifier::Config coil() {
  return {.drive_min = -8.0,
          .drive_max = 8.0,
          .slew_per_s = 1e6,
          .bandwidth_Hz = 1000.0,
          .voltage_limit_V = 10.0,
          .load_mH = 10.0,
          .load_ohm = 2.0};
}

double uniform(double lo, double hi) { return lo + (hi - lo) * 1e-6 * *rc::gen::inRange(0, 1'000'001); }

/// A voltage-limited coil of any size: the lag is steeper or flatter than the load, and the target is within
/// reach or not. The output starts within reach.
struct AnyCoil {
  Amplifier::Config config = coil();
  Amplifier::State state;
  double total_s = 0.0;

  AnyCoil() {
    config.bandwidth_Hz = std::pow(10.0, uniform(0.5, 3.5));
    config.slew_per_s = std::pow(10.0, uniform(1.0, 4.0));
    config.load_mH = std::pow(10.0, uniform(0.0, 2.0));
    config.load_ohm = uniform(0.5, 10.0);
    const double reach = config.voltage_limit_V / config.load_ohm;
    state = {.output = uniform(-reach, reach), .target = uniform(-1.5 * reach, 1.5 * reach)};
    total_s = std::pow(10.0, uniform(-5.0, -1.0));
  }
  double end() const {
    const double reach = config.voltage_limit_V / config.load_ohm;
    return std::clamp(state.target, -reach, reach);
  }
};

TEST(AmplifierWithACapacitor, SlewsAsFastAsItsCurrentChargesIt) {
  const Amplifier::Config config{.slew_per_s = 1e6, .current_limit_A = 0.14, .load_uF = 1.5};
  const auto after = Amplifier(config, 1e-4)({.output = 0.0, .target = 100.0});
  EXPECT_NEAR(after.output, 0.14 / 1.5e-6 * 1e-4, 1e-12);
}

TEST(AmplifierWithACapacitor, KeepsItsSlewLimitIfItsCurrentIsSufficient) {
  const Amplifier::Config config{.slew_per_s = 1000.0, .current_limit_A = 1.0, .load_uF = 1.0};
  EXPECT_DOUBLE_EQ(Amplifier(config, 0.01)({.output = 0.0, .target = 100.0}).output, 10.0);
}

TEST(AmplifierWithACoil, RisesAsAnExponentialWhileItsVoltageIsLimited) {
  const auto after = Amplifier(coil(), 0.003)({.output = 0.0, .target = 4.0});
  EXPECT_NEAR(after.output, 5.0 * (1.0 - std::exp(-0.003 / 0.005)), 1e-12);
}

// The lag begins at 10 - 2 i = 0.01 omega (4 - i), here at i = 3.968 A.
TEST(AmplifierWithACoil, ContinuesWithItsLagOnceItsVoltageIsSufficient) {
  const double omega = two_pi * 1000.0;
  const double i_x = (0.01 * omega * 4.0 - 10.0) / (0.01 * omega - 2.0);
  const double t_x = 0.005 * std::log(5.0 / (5.0 - i_x));
  const auto after = Amplifier(coil(), t_x + 1e-4)({.output = 0.0, .target = 4.0});
  EXPECT_NEAR(after.output, 4.0 - (4.0 - i_x) * std::exp(-omega * 1e-4), 1e-12);
}

TEST(AmplifierWithACoil, NeverReachesATargetBeyondItsVoltage) {
  for (const double target : {7.0, -7.0}) {
    const auto after = Amplifier(coil(), 1.0)({.output = 0.0, .target = target});
    EXPECT_NEAR(after.output, std::copysign(5.0, target), 1e-12);
  }
}

TEST(AmplifierWithACoil, IsSlewLimitedByItsVoltageWithoutResistance) {
  Amplifier::Config ideal = coil();
  ideal.load_ohm = 0.0;
  EXPECT_NEAR(Amplifier(ideal, 1e-3)({.output = 0.0, .target = 4.0}).output, 1.0, 1e-12);
}

TEST(AmplifierWithACoil, KeepsEveryLimitAndReachesItsEndMonotonically) {
  EXPECT_TRUE(rc::check("each small step within slew and voltage, towards the end and never past it", [] {
    const AnyCoil coil;
    const double dt_s = 0.01 * coil.total_s;
    const Amplifier step(coil.config, dt_s);
    const double towards = coil.end() < coil.state.output ? -1.0 : 1.0;
    const double tau_s = 1e-3 * coil.config.load_mH / coil.config.load_ohm;
    const double reach = coil.config.voltage_limit_V / coil.config.load_ohm;
    constexpr double rounding = 1e-12;
    Amplifier::State state = coil.state;
    for (int i = 0; i < 100; ++i) {
      const double before = state.output;
      state = step(state);
      const double moved = towards * (state.output - before);
      const double by_voltage = (reach - towards * before) * -std::expm1(-dt_s / tau_s);
      RC_ASSERT(moved >= -rounding);
      RC_ASSERT(moved <= coil.config.slew_per_s * dt_s + rounding);
      RC_ASSERT(moved <= by_voltage + rounding);
      RC_ASSERT(towards * (coil.end() - state.output) >= -rounding);
    }
  }));
}

TEST(AmplifierWithACoil, ConvergesToItsTargetOrItsVoltageLimit) {
  EXPECT_TRUE(rc::check("after 40 of the slowest time constant and the slew", [] {
    const AnyCoil coil;
    const double slowest_s = std::max(1e-3 * coil.config.load_mH / coil.config.load_ohm,
                                      1.0 / (two_pi * coil.config.bandwidth_Hz));
    const double total_s = 40.0 * slowest_s + 60.0 / coil.config.slew_per_s;
    RC_ASSERT(std::abs(Amplifier(coil.config, total_s)(coil.state).output - coil.end()) <= 1e-12);
  }));
}

TEST(Amplifier, RoundsItsTargetToItsResolutionWithinTheRange) {
  const Amplifier::Config config{.drive_min = -1.0, .drive_max = 10.1, .resolution = 0.25};
  EXPECT_EQ(Amplifier::target_of(config, 3.12), 3.0);
  EXPECT_EQ(Amplifier::target_of(config, -0.4), -0.5);
  EXPECT_EQ(Amplifier::target_of(config, 10.2), 10.1);
  EXPECT_EQ(Amplifier::target_of({}, 3.12), 3.12) << "not quantised";
}

TEST(Amplifier, RampsNoFasterThanConfigured) {
  const Amplifier::Config config{.ramp_per_s = 50.0};
  const auto after =
      Amplifier(config, 0.5)({.output = 80.0, .target = 0.0, .course = Amplifier::Course::ramp});
  EXPECT_DOUBLE_EQ(after.output, 80.0 - 25.0);
  EXPECT_EQ(after.course, Amplifier::Course::ramp);
}

TEST(Amplifier, IsDischargedByItsLoadWhileSwitchedOff) {
  const Amplifier::State off{.output = 80.0, .target = 60.0, .course = Amplifier::Course::off};
  const Amplifier::Config bled{.load_uF = 1.5, .load_ohm = 1e5};  // 150 ms
  EXPECT_NEAR(Amplifier(bled, 0.3)(off).output, 80.0 * std::exp(-2.0), 1e-12);
  EXPECT_NEAR(Amplifier(coil(), 0.005)(off).output, 80.0 * std::exp(-1.0), 1e-12);
  EXPECT_EQ(Amplifier({}, 1e-5)(off).output, 0.0) << "without a load the output is zero at once";
}

}  // namespace
}  // namespace hystcan::twin::amplifier_load_test
