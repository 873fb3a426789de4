#include "controller/timing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/support/count_allocations.h"

namespace hystcan::controller::timing_test {
namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;

TEST(TimeStatistics, AreZeroWithoutTimes) {
  const TimeSummary summary = TimeStatistics().summary();
  EXPECT_EQ(summary.count, 0u);
  EXPECT_EQ(summary.mean_us, 0.0);
  EXPECT_EQ(summary.sd_us, 0.0);
  EXPECT_EQ(summary.p99_us, 0.0);
  EXPECT_EQ(summary.max_us, 0.0);
}

TEST(TimeStatistics, HaveNoSpreadForASingleTime) {
  TimeStatistics statistics;
  statistics.add(nanoseconds(50));
  const TimeSummary summary = statistics.summary();
  EXPECT_EQ(summary.mean_us, 0.05);
  EXPECT_EQ(summary.sd_us, 0.0);
  EXPECT_EQ(summary.p99_us, 0.05) << "exact below 64 ns";
  EXPECT_EQ(summary.max_us, 0.05);
}

/// 1, 2, ... 1000 us: mean (n + 1)/2, SD sqrt(n (n + 1) / 12).
TEST(TimeStatistics, HaveTheTextbookValuesForAnArithmeticSeries) {
  TimeStatistics statistics;
  for (int us = 1000; us >= 1; --us) statistics.add(microseconds(us));
  const TimeSummary summary = statistics.summary();
  EXPECT_EQ(summary.count, 1000u);
  EXPECT_NEAR(summary.mean_us, 500.5, 1e-9);
  EXPECT_NEAR(summary.sd_us, std::sqrt(1000.0 * 1001.0 / 12.0), 1e-9);
  EXPECT_GE(summary.p99_us, 990.0);
  EXPECT_LE(summary.p99_us, 990.0 * 33.0 / 32.0);
  EXPECT_EQ(summary.max_us, 1000.0);
}

/// A plain sum of squares would lose a jitter of 10 ns after a million periods of 1 s.
TEST(TimeStatistics, KeepASmallSpreadAboutALargeMean) {
  TimeStatistics statistics;
  for (int i = 0; i < 1'000'000; ++i) statistics.add(nanoseconds(1'000'000'000 + (i % 2 == 0 ? 10 : -10)));
  EXPECT_NEAR(statistics.summary().sd_us, 0.01, 1e-6);
}

TEST(TimeStatistics, ReportQuantilesAtMostOne32ndAboveTheTrueOnes) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> decades(0.0, 10.8);  // 1 ns to 63 s
  TimeStatistics statistics;
  std::vector<double> times_us;
  times_us.reserve(10'000);
  for (int i = 0; i < 10'000; ++i) {
    const auto ns = static_cast<std::int64_t>(std::pow(10.0, decades(random)));
    statistics.add(nanoseconds(ns));
    times_us.push_back(1e-3 * static_cast<double>(ns));
  }
  std::ranges::sort(times_us);
  for (const double q : {0.001, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto rank = static_cast<std::size_t>(std::ceil(q * 10'000.0));
    const double truth = times_us[rank - 1];
    EXPECT_GE(statistics.quantile_us(q), truth * (1.0 - 1e-12)) << q;
    EXPECT_LE(statistics.quantile_us(q), truth * (33.0 / 32.0)) << q;
  }
}

TEST(TimeStatistics, AcceptTimesOutsideTheHistogram) {
  TimeStatistics statistics;
  statistics.add(std::chrono::hours(1));
  EXPECT_EQ(statistics.quantile_us(0.99), 3.6e9) << "beyond the last class the maximum is reported";
  TimeStatistics before;
  before.add(nanoseconds(-100));  // a timestamp of another clock after a step of that clock
  EXPECT_EQ(before.quantile_us(0.99), 0.0);
  EXPECT_EQ(before.summary().mean_us, -0.1);
}

TEST(TimeStatistics, AllocateNothing) {
  TimeStatistics statistics;
  const std::uint64_t before = support::allocations_so_far();
  for (int i = 0; i < 1000; ++i) statistics.add(microseconds(i));
  const TimeSummary summary = statistics.summary();
  EXPECT_EQ(support::allocations_so_far(), before);
  EXPECT_EQ(summary.count, 1000u);
}

}  // namespace
}  // namespace hystcan::controller::timing_test
