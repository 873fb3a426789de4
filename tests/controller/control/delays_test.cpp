#include "controller/control/delays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace hystcan::controller::delays_test {
namespace {

using Complex = std::complex<double>;

constexpr double cycle_s = 1e-3;
constexpr Delays piezo{.command_delay = std::chrono::milliseconds(1),
                       .amplifier_bandwidth_Hz = 1500.0,
                       .resonance_Hz = 500.0,
                       .damping_ratio = 0.05};
constexpr Notch::Config notch{.frequency_Hz = 300.0, .depth = 0.2, .width = 0.4};

double omega(double frequency_Hz) { return 2.0 * std::numbers::pi * frequency_Hz; }

constexpr Delays interpolated_piezo() {
  Delays delays = piezo;
  delays.interpolated = true;
  return delays;
}

/// The exact response from demand to position: delay, held or interpolated drive, amplifier, mode.
Complex chain(double frequency_Hz, const Delays& delays = piezo) {
  const Complex s(0.0, omega(frequency_Hz)), u = s / omega(delays.resonance_Hz);
  const Complex held = (1.0 - std::exp(-s * cycle_s)) / (s * cycle_s);
  return std::exp(-s * 1e-3) * (delays.interpolated ? held * held : held) /
         (1.0 + s / omega(delays.amplifier_bandwidth_Hz)) / (1.0 + 2.0 * delays.damping_ratio * u + u * u);
}

Complex notch_response(double frequency_Hz) {
  const auto c = Notch::design(notch, cycle_s);
  const Complex back = std::exp(Complex(0.0, -omega(frequency_Hz) * cycle_s));
  return (c.b0 + back * (c.b1 + back * c.b2)) / (1.0 + back * (c.a1 + back * c.a2));
}

/// Returns the response to a complex sine reference with feed-forward; 1 is perfect tracking.
Complex compensator(const Moments& moments, double frequency_Hz) {
  const auto sine = [&](double ahead_s) { return std::exp(Complex(0.0, omega(frequency_Hz) * ahead_s)); };
  return {second_order_preview(moments, cycle_s, [&](double t_s) { return sine(t_s).real(); }),
          second_order_preview(moments, cycle_s, [&](double t_s) { return sine(t_s).imag(); })};
}

TEST(Delays, AddUpToThePreview) {
  const Delays delays{.command_delay = std::chrono::milliseconds(1),
                      .amplifier_bandwidth_Hz = 1000.0,
                      .resonance_Hz = 500.0,
                      .damping_ratio = 0.05};
  // 1 ms until the command acts, 0.5 ms held, 1 / (2 pi 1000 Hz), 2 * 0.05 / (2 pi 500 Hz)
  EXPECT_NEAR(delays.preview_s(1e-3), 1e-3 + 0.5e-3 + 0.15915494e-3 + 0.03183099e-3, 1e-10);
}

TEST(Delays, MomentsAreTheFirstTwoOfTheChainsExactResponse) {
  for (const Delays& delays : {piezo, interpolated_piezo()}) {
    const Moments moments = delays.moments(cycle_s);
    for (const double f : {1.0, 2.0, 4.0}) {
      const Complex log_gain = std::log(chain(f, delays));
      const double w = omega(f);
      EXPECT_NEAR(-log_gain.imag() / w, moments.mean_s, 1e-3 * moments.mean_s) << f;
      // The next term of the real part is of order w^4 / resonance^4.
      EXPECT_NEAR(-2.0 * log_gain.real() / (w * w), moments.variance_s2,
                  1e-3 * std::abs(moments.variance_s2));
    }
  }
}

TEST(Delays, AreHalfACycleLongerForAnInterpolatedDrive) {
  EXPECT_NEAR(interpolated_piezo().preview_s(cycle_s), piezo.preview_s(cycle_s) + cycle_s / 2.0, 1e-15);
}

TEST(Delays, MomentsOfTheNotchMatchTheDiscreteFilter) {
  const Moments moments = notch.moments(cycle_s);
  for (const double f : {1.0, 2.0, 4.0}) {
    const Complex log_gain = std::log(notch_response(f));
    const double w = omega(f);
    EXPECT_NEAR(-log_gain.imag() / w, moments.mean_s, 1e-3 * moments.mean_s) << f;
    EXPECT_NEAR(-2.0 * log_gain.real() / (w * w), moments.variance_s2, 2e-3 * moments.variance_s2) << f;
  }
}

// Without compensation of the variance, |error| is var w^2 / 2, with it O(w^3): the quotient decreases with
// w.
TEST(Delays, SecondOrderLeavesAnErrorOfThirdOrder) {
  const Moments both = piezo.moments(cycle_s);
  const Moments mean_only{.mean_s = both.mean_s};
  for (const double f : {5.0, 10.0, 20.0, 50.0}) {
    const double first = std::abs(compensator(mean_only, f) * chain(f) - 1.0);
    const double second = std::abs(compensator(both, f) * chain(f) - 1.0);
    EXPECT_LT(second, 0.25 * first) << f << " Hz: " << first << " -> " << second;
    EXPECT_NEAR(first, 0.5 * std::abs(both.variance_s2) * omega(f) * omega(f), 0.1 * first) << f;
  }
}

TEST(Delays, SecondOrderIncludesTheNotch) {
  const Moments with_notch = piezo.moments(cycle_s) + notch.moments(cycle_s);
  for (const double f : {5.0, 10.0, 20.0}) {
    const double second = std::abs(compensator(with_notch, f) * chain(f) * notch_response(f) - 1.0);
    EXPECT_LT(second,
              0.1 * std::abs(compensator(piezo.moments(cycle_s), f) * chain(f) * notch_response(f) - 1.0))
        << f;
  }
}

TEST(Delays, SecondOrderDoesNotChangeARamp) {
  const auto ramp = [](double ahead_s) { return 3.0 + 100.0 * ahead_s; };
  EXPECT_NEAR(second_order_preview(piezo.moments(cycle_s), cycle_s, ramp), ramp(piezo.preview_s(cycle_s)),
              1e-12);
}

}  // namespace
}  // namespace hystcan::controller::delays_test
