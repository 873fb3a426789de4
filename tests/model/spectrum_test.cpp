#include "model/spectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace hystcan::model::spectrum_test {
namespace {

constexpr std::size_t length = 64;

std::vector<double> cosine(double periods) {
  std::vector<double> values(length);
  for (std::size_t n = 0; n < length; ++n)
    values[n] = std::cos(2.0 * std::numbers::pi * periods * static_cast<double>(n) / length);
  return values;
}

TEST(HannTransform, GivesAQuarterOfTheLengthForACosineOfWholePeriods) {
  const auto spectrum = HannTransform(length)(cosine(10.0));
  EXPECT_NEAR(std::abs(spectrum[10] - length / 4.0), 0.0, 1e-12);
}

TEST(HannTransform, HasNothingTwoFrequenciesBesideACosineOfWholePeriods) {
  const auto spectrum = HannTransform(length)(cosine(10.0));
  EXPECT_NEAR(std::abs(spectrum[12]), 0.0, 1e-12);
}

TEST(HannTransform, ReachesFromZeroToHalfTheRate) {
  EXPECT_EQ(HannTransform(length)(cosine(1.0)).size(), length / 2 + 1);
}

}  // namespace
}  // namespace hystcan::model::spectrum_test
