#include "twin/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/twin/twin_bench.h"

namespace hystcan::twin::drive_noise_test {
namespace {

using std::chrono::microseconds;

constexpr microseconds substep{50};

TEST(DriveNoise, HasTheVarianceOfItsDensityUpToHalfTheRateOfItsSubSteps) {
  DriveNoise noise({.density_per_rtHz = 2e-6}, substep, can::Time{}, 42);
  constexpr int samples = 100'000;
  double sum = 0.0;
  double squares = 0.0;
  double neighbours = 0.0;
  double last = 0.0;
  for (int i = 0; i < samples; ++i) {
    const double value = noise(can::Time{} + i * substep);
    sum += value;
    squares += value * value;
    neighbours += value * last;
    last = value;
  }
  const double rms = 2e-6 * std::sqrt(10'000.0);  // 1 / (2 * 50 us) = 10 kHz
  // Five standard errors of the mean, of the spread, and of a correlation that is zero.
  EXPECT_NEAR(sum / samples, 0.0, 5 * rms / std::sqrt(samples));
  EXPECT_NEAR(std::sqrt(squares / samples), rms, 5 * rms / std::sqrt(2.0 * samples));
  EXPECT_NEAR(neighbours / squares, 0.0, 5 / std::sqrt(samples));
}

TEST(DriveNoise, HasASineAsItsRipple) {
  DriveNoise noise({.ripple = 0.01, .ripple_Hz = 100.0}, substep, can::Time{} + microseconds(7), 1);
  EXPECT_NEAR(noise(can::Time{} + microseconds(7)), 0.0, 1e-15);
  EXPECT_NEAR(noise(can::Time{} + microseconds(2507)), 0.01, 1e-15);
  EXPECT_NEAR(noise(can::Time{} + microseconds(7507)), -0.01, 1e-15);
}

TEST(DriveNoise, IsTheSameFromTheSameSeed) {
  DriveNoise a({.density_per_rtHz = 1e-6}, substep, can::Time{}, 7);
  DriveNoise b({.density_per_rtHz = 1e-6}, substep, can::Time{}, 7);
  DriveNoise other({.density_per_rtHz = 1e-6}, substep, can::Time{}, 8);
  const double first = a(can::Time{});
  EXPECT_EQ(first, b(can::Time{}));
  EXPECT_NE(first, other(can::Time{}));
}

TEST(DriveNoise, IsZeroByDefault) {
  DriveNoise noise({}, substep, can::Time{}, 1);
  EXPECT_TRUE(noise.is_silent());
  EXPECT_EQ(noise(can::Time{}), 0.0);
  EXPECT_FALSE(DriveNoise({.ripple = 0.1}, substep, can::Time{}, 1).is_silent());
}

// A ripple of 0.5 V and 50 Hz about 40 V appears in the amplifier's status and in the position.
TEST(DriveNoise, AppearsInTheStatusOfTheAmplifierAndInThePosition) {
  Config config = one_axis();
  config.axes.front().axis.drive_noise = {.ripple = 0.5, .ripple_Hz = 50.0};
  config.axes.front().axis.status_every = 1;
  TwinBench bench(config);
  bench.start_nodes();
  bench.drive(40.0, 200);
  double lowest_V = 1e9;
  double highest_V = -1e9;
  double lowest_um = 1e9;
  double highest_um = -1e9;
  for (int i = 0; i < 40; ++i) {
    bench.drive(40.0, 1);
    lowest_V = std::min(lowest_V, bench.status_->output);
    highest_V = std::max(highest_V, bench.status_->output);
    lowest_um = std::min(lowest_um, bench.sample_->position_um);
    highest_um = std::max(highest_um, bench.sample_->position_um);
  }
  EXPECT_NEAR(lowest_V, 39.5, 0.02) << "twenty samples in a period: within 1 - cos(9 deg) of the amplitude";
  EXPECT_NEAR(highest_V, 40.5, 0.02);
  EXPECT_GT(highest_um - lowest_um, 0.1) << "a small loop is flatter than the main curve";
}

}  // namespace
}  // namespace hystcan::twin::drive_noise_test
