#include "metrics/statistics.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace hystcan::metrics::statistics_test {
namespace {

TEST(ErrorStatistics, AreZeroWithoutSamples) { EXPECT_EQ(ErrorStatistics{}.rms_um(), 0.0); }

TEST(ErrorStatistics, CanBeMergedFromParts) {
  ErrorStatistics first, second, whole;
  for (const double error_um : {1.0, -3.0}) first.add(error_um), whole.add(error_um);
  second.add(2.0), whole.add(2.0);
  first.add(second);
  EXPECT_EQ(first.rms_um(), whole.rms_um());
  EXPECT_EQ(first.max_um, 3.0);
}

TEST(Histogram, CountsAValueOnAnEdgeBelowIt) {
  Histogram histogram({1.0, 2.0});
  for (const double value : {0.5, 1.0, 1.5, 2.5}) histogram.add(value);
  EXPECT_EQ(histogram.counts(), (std::vector<std::uint64_t>{2, 1, 1}));
}

TEST(Histogram, IgnoresValuesThatAreNotFinite) {
  Histogram histogram = Histogram::of_width(1.0, 3);
  histogram.add(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(histogram.samples(), 0U);
}

}  // namespace
}  // namespace hystcan::metrics::statistics_test
