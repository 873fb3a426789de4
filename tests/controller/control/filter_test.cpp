#include "controller/control/delays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>

namespace hystcan::controller::filter_test {
namespace {

using Complex = std::complex<double>;

constexpr double cycle_s = 1e-3;
constexpr Notch::Config notch{.frequency_Hz = 150.0, .depth = 0.1, .width = 0.3};

/// The analytic N(s) at the frequency to which the bilinear transform maps `frequency_Hz`.
Complex analytic(double frequency_Hz) {
  const double warped = std::tan(std::numbers::pi * frequency_Hz * cycle_s) /
                        std::tan(std::numbers::pi * notch.frequency_Hz * cycle_s);
  const Complex s(0.0, warped);
  return (s * s + 2.0 * notch.depth * notch.width * s + 1.0) / (s * s + 2.0 * notch.width * s + 1.0);
}

/// The measured response: the filter settles on a sine, then its output is correlated over whole periods.
Complex measured(double frequency_Hz) {
  const auto coefficients = Notch::design(notch, cycle_s);
  Notch::State state;
  Complex sum = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const double angle = 2.0 * std::numbers::pi * frequency_Hz * i * cycle_s;
    const double y = Notch::step(coefficients, state, std::sin(angle));
    if (i >= 2000) sum += y * std::exp(Complex(0.0, -angle));
  }
  return sum * Complex(0.0, 2.0) / 1000.0;
}

TEST(Notch, HasTheAnalyticTransferFunction) {
  for (const double f : {1.0, 10.0, 50.0, 100.0, 140.0, 150.0, 160.0, 300.0, 450.0})
    EXPECT_NEAR(std::abs(measured(f) - analytic(f)), 0.0, 1e-9) << f << " Hz";
}

TEST(Notch, HasItsDepthAsTheGainAtItsFrequency) { EXPECT_NEAR(std::abs(measured(150.0)), notch.depth, 1e-9); }

TEST(Notch, HasGainOneAtRestToTheBit) {
  const auto coefficients = Notch::design(notch, cycle_s);
  Notch::State state = Notch::at_rest(12.345678);
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(Notch::step(coefficients, state, 12.345678), 12.345678);
  for (int i = 0; i < 1000; ++i) Notch::step(coefficients, state, 7.1);
  EXPECT_NEAR(Notch::step(coefficients, state, 7.1), 7.1, 1e-12);
}

TEST(Notch, IsShiftedByAConstantWithoutATransient) {
  const auto coefficients = Notch::design(notch, cycle_s);
  Notch::State state = Notch::at_rest(0.0);
  for (int i = 0; i < 5; ++i) Notch::step(coefficients, state, 1.0);
  Notch::State moved = state;
  Notch::shift(moved, 3.0);
  for (int i = 0; i < 20; ++i)
    EXPECT_NEAR(Notch::step(coefficients, moved, 4.0), Notch::step(coefficients, state, 1.0) + 3.0, 1e-12);
}

TEST(Notch, RefusesAFrequencyBeyondHalfTheRate) {
  EXPECT_THROW(Notch::design({.frequency_Hz = 500.0}, cycle_s), std::invalid_argument);
  EXPECT_THROW(Notch::design({.frequency_Hz = 100.0, .depth = 1.5}, cycle_s), std::invalid_argument);
  EXPECT_THROW(Notch::design({.frequency_Hz = 100.0, .depth = 0.1, .width = 0.0}, cycle_s),
               std::invalid_argument);
}

TEST(LowPass, FollowsAStepAsAFirstOrderLag) {
  double y = 0.0;
  for (int i = 0; i < 10; ++i) y = low_pass(20.0, y, 1.0, cycle_s);
  EXPECT_NEAR(y, 1.0 - std::exp(-2.0 * std::numbers::pi * 20.0 * 0.01), 1e-12);
  EXPECT_EQ(low_pass(20.0, 1.5, 1.5, cycle_s), 1.5) << "gain 1 at rest";
}

TEST(Deadband, IsContinuousAndReducesTheErrorByItsWidth) {
  for (const auto& [error, expected] :
       {std::pair{0.5, 0.3}, {0.2, 0.0}, {0.1, 0.0}, {-0.1, 0.0}, {-0.5, -0.3}})
    EXPECT_NEAR(outside_deadband(error, 0.2), expected, 1e-15);
  EXPECT_EQ(outside_deadband(0.7, 0.0), 0.7);
}

}  // namespace
}  // namespace hystcan::controller::filter_test
