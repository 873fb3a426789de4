#include "metrics/spectrum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

namespace hystcan::metrics::spectrum_test {
namespace {

constexpr double rate_Hz = 1024.0;

TEST(Spectrum, HasThePowerOfASineAtItsFrequency) {
  Spectrum spectrum(rate_Hz, 1024);
  constexpr double amplitude = 0.3, frequency_Hz = 50.0;
  for (int i = 0; i < 8192; ++i)
    spectrum.add(amplitude * std::sin(2.0 * std::numbers::pi * frequency_Hz * i / rate_Hz));
  const auto densities = spectrum.densities(), frequencies = spectrum.frequencies_Hz();
  const auto peak = std::ranges::max_element(densities) - densities.begin();
  EXPECT_DOUBLE_EQ(frequencies[static_cast<std::size_t>(peak)], frequency_Hz);
  double power = 0.0;
  for (const double density : densities) power += density * density * rate_Hz / 1024.0;
  EXPECT_NEAR(power, amplitude * amplitude / 2.0, 1e-9);
}

TEST(Spectrum, IsFlatForWhiteNoise) {
  Spectrum spectrum(rate_Hz, 256);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.1);
  for (int i = 0; i < 400'000; ++i) spectrum.add(5.0 + noise(random));
  const double expected = 0.1 * std::sqrt(2.0 / rate_Hz);
  const std::vector<double> densities = spectrum.densities();
  for (std::size_t i = 2; i + 2 < densities.size(); ++i) EXPECT_NEAR(densities[i], expected, 0.1 * expected);
}

/// The page's spectrum has the same numbers: tests/page/spectrum_test.mjs.
TEST(Spectrum, HasTheDensityOfTheSharedNumbers) {
  const auto shared = nlohmann::json::parse(std::ifstream(HYSTCAN_SOURCE_DIR "/tests/metrics/spectrum.json"));
  Spectrum spectrum(shared.at("rate_Hz"), shared.at("size"));
  for (const double value : shared.at("values")) spectrum.add(value);
  const std::vector<double> densities = spectrum.densities(), expected = shared.at("density");
  ASSERT_EQ(densities.size(), expected.size());
  EXPECT_EQ(spectrum.segments(), shared.at("segments"));
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(densities[i], expected[i], 1e-8);
}

TEST(Spectrum, DoesNotSpanAGap) {
  Spectrum spectrum(rate_Hz, 64);
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 63; ++j) spectrum.add(1.0);
    spectrum.break_off();
  }
  EXPECT_EQ(spectrum.segments(), 0U);
  EXPECT_TRUE(spectrum.densities().empty());
}

}  // namespace
}  // namespace hystcan::metrics::spectrum_test
