#include "model/held_mode.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace hystcan::model::held_mode_test {
namespace {

constexpr double pi = std::numbers::pi;

// x(t) of an underdamped mode after a unit step at t = 0.
double step_response(const SecondOrder::Config& mode, double t) {
  if (t <= 0.0) return 0.0;
  const double omega = 2.0 * pi * mode.natural_frequency_Hz, zeta = mode.damping_ratio;
  const double root = std::sqrt(1.0 - zeta * zeta), w = omega * root;
  return 1.0 - std::exp(-zeta * omega * t) * (std::cos(w * t) + zeta / root * std::sin(w * t));
}

TEST(HeldMode, FollowsTheClosedFormOfALateStep) {
  const SecondOrder::Config mode{430.0, 0.07};
  const double cycle_s = 1e-3;
  for (const double delay_s : {-0.4e-3, 0.0, 1e-9, 0.3e-3, 1e-3, 2.71e-3}) {
    const HeldMode held(mode, delay_s, cycle_s);
    const auto drive = [](int n) { return n >= 0 ? 1.0 : 0.0; };
    Eigen::Vector2d state = Eigen::Vector2d::Zero();
    for (int n = -3; n < 30; ++n) {
      // The tolerance is the rounding of about thirty steps.
      EXPECT_NEAR(state[0], step_response(mode, n * cycle_s - delay_s), 1e-12) << delay_s << ' ' << n;
      state = held.step(state, drive(n - held.whole_cycles() - 1), drive(n - held.whole_cycles()));
    }
  }
}

TEST(HeldMode, RespondsToASineAccordingToItsFrequencyResponse) {
  const HeldMode held({430.0, 0.07}, 2.71e-3, 1e-3);
  const double theta = 1.1;
  const auto drive = [&](int n) { return std::cos(theta * n); };
  Eigen::Vector2d state = Eigen::Vector2d::Zero();
  const int settled = 2000;  // e^(-zeta omega t) = e^-378
  for (int n = 0; n < settled; ++n)
    state = held.step(state, drive(n - held.whole_cycles() - 1), drive(n - held.whole_cycles()));
  EXPECT_NEAR(state[0], (held.response(theta) * std::polar(1.0, theta * settled)).real(), 1e-11);
}

TEST(HeldMode, HasUnitGainAtRest) {
  for (const double delay_s : {0.0, 0.3e-3, 5e-3})
    EXPECT_NEAR(std::abs(HeldMode({430.0, 0.07}, delay_s, 1e-3).response(0.0) - 1.0), 0.0, 1e-12);
}

// With a hundred samples per period, the hold is only a delay of half a cycle.
TEST(HeldMode, HasAPeakOfOneOverTwiceTheDamping) {
  const double frequency_Hz = 100.0, cycle_s = 1e-4;
  for (const double zeta : {0.01, 0.05, 0.2})
    EXPECT_NEAR(
        std::abs(HeldMode({frequency_Hz, zeta}, 0.0, cycle_s).response(2.0 * pi * frequency_Hz * cycle_s)) *
            2.0 * zeta,
        1.0, 2e-3);
}

TEST(HeldMode, RefusesAnInvalidDelayOrCycle) {
  EXPECT_THROW(HeldMode({430.0, 0.07}, std::nan(""), 1e-3), std::invalid_argument);
  EXPECT_THROW(HeldMode({430.0, 0.07}, 1e9, 1e-3), std::invalid_argument);
  EXPECT_THROW(HeldMode({430.0, 0.07}, 0.0, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::model::held_mode_test
