#include "twin/sensor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hystcan::twin::sensor_test {
namespace {

constexpr can::Time start{};

TEST(Sensor, QuantisesToItsResolution) {
  Sensor sensor({.noise_um_rms = 0.0, .resolution_um = 0.25}, 1);
  EXPECT_EQ(sensor.measure(start, 1.10).position_um, 1.0);
  EXPECT_EQ(sensor.measure(start, -1.20).position_um, -1.25);
}

TEST(Sensor, MeasuresThePositionExactlyByDefault) {
  Sensor sensor({}, 1);
  EXPECT_EQ(sensor.measure(start, 1.23456789).position_um, 1.23456789);
}

TEST(Sensor, NoiseHasTheStatedSpreadAndNoBias) {
  Sensor sensor({.noise_um_rms = 0.01}, 42);
  constexpr int samples = 100'000;
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < samples; ++i) {
    const double noise = sensor.measure(start, 5.0).position_um - 5.0;
    sum += noise;
    squares += noise * noise;
  }
  // Five standard errors: 0.01 / sqrt(1e5) for the mean, 0.01 / sqrt(2e5) for the spread.
  EXPECT_NEAR(sum / samples, 0.0, 5 * 0.01 / std::sqrt(samples));
  EXPECT_NEAR(std::sqrt(squares / samples), 0.01, 5 * 0.01 / std::sqrt(2.0 * samples));
}

TEST(Sensor, TheSameSeedGivesTheSameNoise) {
  Sensor a({.noise_um_rms = 0.01}, 7);
  Sensor b({.noise_um_rms = 0.01}, 7);
  Sensor other({.noise_um_rms = 0.01}, 8);
  const double first = a.measure(start, 0.0).position_um;
  EXPECT_EQ(first, b.measure(start, 0.0).position_um);
  EXPECT_NE(first, other.measure(start, 0.0).position_um);
}

}  // namespace
}  // namespace hystcan::twin::sensor_test
