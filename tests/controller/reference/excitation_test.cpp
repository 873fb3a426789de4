#include "controller/reference/excitation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace hystcan::controller::excitation_test {
namespace {

/// Returns the drive of every cycle, from before the start to after the end.
std::vector<double> sampled(const Excitation& excitation, double cycle_s = 1e-3) {
  std::vector<double> drives;
  for (double t_s = -10 * cycle_s; t_s < excitation.length_s() + 10 * cycle_s; t_s += cycle_s)
    drives.push_back(excitation.at(t_s));
  return drives;
}

/// The drives of all turning points and of both ends.
std::vector<double> reversals(const std::vector<double>& drives) {
  std::vector<double> found{drives.front()};
  double way = 0.0;
  for (std::size_t i = 1; i < drives.size(); ++i) {
    const double change = drives[i] - drives[i - 1];
    if (change * way < 0.0) found.push_back(drives[i - 1]);
    if (change != 0.0) way = change;
  }
  found.push_back(drives.back());
  return found;
}

/// Odd numbers, so that no turning point coincides with a cycle.
const Excitation::Hysteresis odd{
    .low = -3.7, .high = 91.3, .slew_per_s = 123.4, .rest_s = 0.002, .loops = 3, .levels = 4};

TEST(HysteresisExcitation, TurnsExactlyAtEachOfItsTurningPoints) {
  EXPECT_EQ(reversals(sampled(Excitation(odd))), turning_points(odd));
}

TEST(HysteresisExcitation, HasMajorLoopsNestedLoopsAndReversalCurves) {
  const Excitation::Hysteresis h{.low = 0.0, .high = 120.0, .loops = 2, .levels = 2};
  const std::vector<double> expected{0,   120, 0,   120, 0,    // major loops
                                     100, 20,  80,  40,        // nested, amplitudes 2/3 and 1/3 of 60
                                     120, 80,  120, 40,  120,  // from above
                                     0,   40,  0,   80,  0};   // from below
  const std::vector<double> points = turning_points(h);
  ASSERT_EQ(points.size(), expected.size());
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(points[i], expected[i], 1e-12) << i;
}

TEST(HysteresisExcitation, HasOnlyMajorLoopsWithoutLevels) {
  EXPECT_EQ(turning_points({.low = 1.0, .high = 2.0, .loops = 1, .levels = 0}),
            (std::vector<double>{1.0, 2.0, 1.0}));
}

TEST(HysteresisExcitation, KeepsRangeAndSlewAndReturnsToItsStart) {
  const Excitation excitation(odd);
  const std::vector<double> drives = sampled(excitation);
  const auto [least, most] = std::ranges::minmax(drives);
  EXPECT_EQ(least, odd.low);
  EXPECT_EQ(most, odd.high);
  EXPECT_EQ(excitation.range().lo, odd.low);
  EXPECT_EQ(excitation.range().hi, odd.high);
  EXPECT_EQ(drives.front(), odd.low);
  EXPECT_EQ(drives.back(), odd.low);
  double steepest = 0.0;
  for (std::size_t i = 1; i < drives.size(); ++i)
    steepest = std::max(steepest, std::abs(drives[i] - drives[i - 1]));
  EXPECT_NEAR(steepest, odd.slew_per_s * 1e-3, 1e-9);
}

TEST(HysteresisExcitation, LastsAsLongAsItsRampsAndRests) {
  double way = 0.0;
  const std::vector<double> points = turning_points(odd);
  for (std::size_t i = 1; i < points.size(); ++i) way += std::abs(points[i] - points[i - 1]);
  EXPECT_NEAR(Excitation(odd).length_s(),
              way / odd.slew_per_s + static_cast<double>(points.size()) * odd.rest_s, 1e-9);
}

TEST(StepExcitation, StepsUpAndDownAboutTheCentre) {
  const Excitation excitation(
      Excitation::Steps{.centre = 50.0, .amplitude = 5.0, .period_s = 0.2, .cycles = 3});
  EXPECT_DOUBLE_EQ(excitation.length_s(), 0.8);
  for (const auto& [t_s, drive] : {std::pair{0.05, 50.0},
                                   {0.15, 55.0},
                                   {0.25, 45.0},
                                   {0.35, 55.0},
                                   {0.45, 45.0},
                                   {0.55, 55.0},
                                   {0.65, 45.0},
                                   {0.75, 50.0},
                                   {9.0, 50.0}})
    EXPECT_EQ(excitation.at(t_s), drive) << t_s;
}

/// Frequency from the time between two neighbouring zero crossings.
double frequency_Hz(const Excitation& excitation, double centre, double around_s) {
  constexpr double step_s = 1e-6;
  std::vector<double> crossings_s;
  for (double t_s = around_s; crossings_s.size() < 3; t_s += step_s)
    if ((excitation.at(t_s) - centre) * (excitation.at(t_s + step_s) - centre) < 0.0)
      crossings_s.push_back(t_s);
  return 1.0 / (crossings_s[2] - crossings_s[0]);
}

TEST(ChirpExcitation, SweepsItsFrequenciesAtItsAmplitudeAboutTheCentre) {
  const Excitation::Chirp c{
      .centre = 40.0, .amplitude = 3.0, .from_Hz = 50.0, .to_Hz = 250.0, .duration_s = 10.0};
  const Excitation excitation(c);
  EXPECT_EQ(excitation.at(0.0), 40.0);
  // One period later the frequency has changed by 20 Hz/s / f: at most 0.8 % of 50 Hz.
  EXPECT_NEAR(frequency_Hz(excitation, 40.0, 0.0), 50.0, 0.5);
  EXPECT_NEAR(frequency_Hz(excitation, 40.0, 5.0), 150.0, 0.3);
  EXPECT_NEAR(frequency_Hz(excitation, 40.0, 9.9), 248.0, 0.3);
  const auto drives = sampled(excitation, 1e-4);
  const auto [least, most] = std::ranges::minmax(drives);
  EXPECT_GE(least, 37.0);
  EXPECT_LE(most, 43.0);
  // Samples of a 250 Hz sine every 0.1 ms miss its peak by at most 1 - cos(pi 250 1e-4) = 0.3 %.
  EXPECT_NEAR(most - least, 6.0, 0.02);
  for (std::size_t i = 1; i < drives.size(); ++i)
    ASSERT_LE(std::abs(drives[i] - drives[i - 1]), excitation.steepest_per_s() * 1e-4);
}

TEST(Excitation, RefusesInvalidNumbers) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::vector<Excitation::Config> nonsense{Excitation::Hysteresis{.low = 5.0, .high = 5.0},
                                                 Excitation::Hysteresis{.low = nan},
                                                 Excitation::Hysteresis{.high = infinity},
                                                 Excitation::Hysteresis{.slew_per_s = 0.0},
                                                 Excitation::Hysteresis{.slew_per_s = 1e-6},
                                                 Excitation::Hysteresis{.rest_s = -1.0},
                                                 Excitation::Hysteresis{.loops = 0},
                                                 Excitation::Hysteresis{.levels = 1'000'000'000},
                                                 Excitation::Steps{.amplitude = -1.0},
                                                 Excitation::Steps{.period_s = 0.0},
                                                 Excitation::Steps{.cycles = 0},
                                                 Excitation::Chirp{.amplitude = nan},
                                                 Excitation::Chirp{.from_Hz = 0.0},
                                                 Excitation::Chirp{.duration_s = infinity}};
  for (const auto& config : nonsense) EXPECT_THROW(Excitation{config}, std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::controller::excitation_test
