#include "identification/dynamics/empirical_response.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "model/held_mode.h"

namespace hystcan::identification::empirical_response_test {
namespace {

constexpr double cycle_s = 1e-3;
const model::HeldMode mode({150.0, 0.1}, 0.4e-3, cycle_s);

/// Steps up and down by 1 about 50, each of 200 rows; 0.3 times the response of the mode, with noise.
Dataset stepped(double noise) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, 1.0);
  Dataset dataset{"V", "um", {}, {}, {}};
  const auto drive = [](int n) { return n < 0 ? 49.0 : 49.0 + 2.0 * ((n / 200) % 2); };
  Eigen::Vector2d state(49.0, 0.0);
  for (int n = 0; n < 4000; ++n) {
    dataset.time_s.push_back(n * cycle_s);
    dataset.input.push_back(drive(n));
    dataset.output.push_back(0.3 * state[0] + noise * normal(random));
    state = mode.step(state, drive(n - 1), drive(n));
  }
  return dataset;
}

/// The largest |H / (0.3 G) - 1| up to `highest_Hz`.
double largest_error(const Dataset& dataset, double highest_Hz) {
  double largest = 0.0;
  for (const ResponsePoint& point : empirical_response(dataset)) {
    if (point.frequency_Hz > highest_Hz) break;
    const auto truth = 0.3 * mode.response(2.0 * std::numbers::pi * point.frequency_Hz * cycle_s);
    largest = std::max(largest, std::abs(point.response / truth - 1.0));
  }
  return largest;
}

// The window of 512 rows cuts off part of the ringing.
TEST(EmpiricalResponse, MatchesTheModeInAStepTrain) {
  EXPECT_GT(empirical_response(stepped(0.0)).size(), 200u);
  EXPECT_LT(largest_error(stepped(0.0), 300.0), 0.15);
  EXPECT_LT(largest_error(stepped(0.0), 100.0), 0.1);
}

TEST(EmpiricalResponse, HasACoherenceNearOneWithoutNoiseAndLessWithNoise) {
  double least = 1.0, least_with_noise = 1.0;
  for (const ResponsePoint& point : empirical_response(stepped(0.0)))
    least = std::min(least, point.coherence);
  for (const ResponsePoint& point : empirical_response(stepped(0.05)))
    least_with_noise = std::min(least_with_noise, point.coherence);
  EXPECT_GT(least, 0.9);
  EXPECT_LT(least_with_noise, 0.5);
  EXPECT_GE(least_with_noise, 0.0);
}

TEST(EmpiricalResponse, BridgesMissingRows) {
  Dataset gaps = stepped(0.0);
  for (const std::ptrdiff_t row : {3333, 2150, 1090, 351})
    for (auto* column : {&gaps.time_s, &gaps.input, &gaps.output}) column->erase(column->begin() + row);
  EXPECT_LT(largest_error(gaps, 150.0), 0.15);
}

TEST(EmpiricalResponse, IsEmptyForAFewRows) {
  EXPECT_TRUE(empirical_response({"V", "um", {0.0, 1.0}, {0, 1}, {0, 1}}).empty());
}

}  // namespace
}  // namespace hystcan::identification::empirical_response_test
