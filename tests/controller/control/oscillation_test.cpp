// Stable and unstable loops, with T = 1 um at 1 kHz.
#include "controller/control/oscillation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

namespace hystcan::controller::oscillation_test {
namespace {

using Signal = std::function<double(int)>;

double sine(double frequency_Hz, int n) { return std::sin(2.0 * std::numbers::pi * frequency_Hz * 1e-3 * n); }

/// Returns the cycle in which the loop is found unstable.
std::optional<int> unstable_at(const Signal& reference_um, const Signal& error_um, int cycles = 20'000,
                               double amplitude_um = 1.0) {
  Oscillation oscillation(amplitude_um);
  for (int n = 0; n < cycles; ++n)
    if (oscillation.step(reference_um(n), reference_um(n) - error_um(n))) return n;
  return {};
}

double at_rest(int /*n*/) { return 15.0; }

constexpr double far_um = 4.0;  // following_error_um and position_jump_um are at least this

/// 24 um at 10 Hz: the reference of the shipped piezo stage.
double triangle(int n) { return 3.0 + 24.0 * std::abs((n % 100) / 50.0 - 1.0); }

// Growth by 2 per half-period takes two more half-periods, from the sufficient swing to the turn after it.
TEST(Oscillation, IsFoundEarlyIfItGrows) {
  for (const double frequency_Hz : {37.0, 110.0, 180.0, 222.2, 333.3})
    for (const double growth_per_half_period : {1.002, 1.02, 1.1, 1.5, 2.0})
      for (const Signal& reference_um : {Signal(at_rest), Signal(triangle)}) {
        double largest_um = 0.0;
        const auto error_um = [&](int n) {
          const double half_periods = 2.0 * frequency_Hz * 1e-3 * n;
          const double value_um =
              0.01 * std::pow(growth_per_half_period, half_periods) * sine(frequency_Hz, n);
          largest_um = std::max(largest_um, std::abs(value_um));
          return value_um;
        };
        ASSERT_TRUE(unstable_at(reference_um, error_um, 100'000));
        EXPECT_LT(largest_um, growth_per_half_period < 2.0 ? far_um : 2.0 * far_um)
            << frequency_Hz << " Hz, growth " << growth_per_half_period;
      }
}

TEST(Oscillation, IsFoundIfItStaysAboveTheAmplitude) {
  for (const double frequency_Hz : {7.0, 180.0, 222.2, 333.3}) {
    const auto limit_cycle = [&](double size_um) {
      return unstable_at(at_rest, [=](int n) { return size_um * sine(frequency_Hz, n); });
    };
    EXPECT_TRUE(limit_cycle(1.3)) << frequency_Hz;
    EXPECT_FALSE(limit_cycle(0.95)) << frequency_Hz;
  }
}

TEST(Oscillation, IsNotFoundIfItDecays) {
  for (const double frequency_Hz : {37.0, 180.0, 222.2, 333.3, 500.0})
    for (const double damping : {0.005, 0.02, 0.05}) {
      const auto ringing = [&](int n) {
        const double radians = 2.0 * std::numbers::pi * frequency_Hz * 1e-3 * n;
        return 20.0 * std::exp(-damping * radians) * std::cos(radians);
      };
      EXPECT_FALSE(unstable_at(at_rest, ringing)) << frequency_Hz << " Hz, damping " << damping;
    }
}

TEST(Oscillation, IsNotFoundInNoise) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise_um(0.0, 0.2);
  EXPECT_FALSE(unstable_at(
      at_rest, [&](int) { return noise_um(random); }, 1'000'000));
}

TEST(Oscillation, IsNotFoundInSpikesOfTheSensor) {
  for (const int every : {2 * 7, 30, 100})
    EXPECT_FALSE(unstable_at(at_rest, [=](int n) { return n % every == 0 ? 3.9 : 0.01 * sine(190.0, n); }));
}

TEST(Oscillation, IsNotFoundInStepsOfTheReference) {
  const auto levels = [](int n) { return (n / 200) % 2 == 0 ? 20.0 : -5.0; };
  const auto error = [](int n) { return ((n / 200) % 2 == 0 ? 25.0 : -25.0) * std::exp(-0.05 * (n % 200)); };
  EXPECT_FALSE(unstable_at(levels, error));
}

TEST(Oscillation, IsNotFoundInKnocks) {
  const auto knocks = [](int n) { return 3.9 * std::exp(-0.05 * (n % 200)); };
  EXPECT_FALSE(unstable_at(at_rest, knocks));
}

/// Returns the error of a reference that drives a mode without feedback.
Signal error_of_mode(const Signal& reference_um, double frequency_Hz, double damping) {
  double y_um = 0.0, velocity = 0.0;
  return [=](int n) mutable {
    const double omega = 2.0 * std::numbers::pi * frequency_Hz, dt_s = 1e-6;
    for (int i = 0; i < 1000; ++i) {
      velocity += dt_s * (omega * omega * (reference_um(n) - y_um) - 2.0 * damping * omega * velocity);
      y_um += dt_s * velocity;
    }
    return reference_um(n) - y_um;
  };
}

TEST(Oscillation, IsNotFoundInAChirpThroughTheResonance) {
  const auto chirp = [](int n) {
    const double t_s = 1e-3 * n;
    return 0.5 * std::sin(2.0 * std::numbers::pi * (20.0 + 15.0 * t_s) * t_s);  // to 320 Hz in 10 s
  };
  for (const double damping : {0.02, 0.05})
    EXPECT_FALSE(unstable_at(chirp, error_of_mode(chirp, 220.0, damping), 10'000)) << damping;
}

TEST(Oscillation, IsNotFoundInTrianglesThatExciteTheMode) {
  EXPECT_FALSE(unstable_at(triangle, error_of_mode(triangle, 220.0, 0.02)));
}

TEST(Oscillation, IsNotJudgedWithAnInfiniteAmplitude) {
  const auto huge = [](int n) { return 100.0 * sine(180.0, n); };
  EXPECT_FALSE(unstable_at(at_rest, huge, 20'000, std::numeric_limits<double>::infinity()));
}

TEST(Oscillation, StartsAgainAfterRestart) {
  const auto large = [](int n) { return 2.0 * sine(180.0, n); };
  const int found = unstable_at(at_rest, large).value();
  Oscillation oscillation(1.0);
  for (int n = 0; n < 10 * found; ++n) {
    if (n % (found / 2) == 0) oscillation.restart();
    ASSERT_FALSE(oscillation.step(15.0, 15.0 - large(n)));
  }
}

}  // namespace
}  // namespace hystcan::controller::oscillation_test
