#include "identification/dynamics/joint_dynamics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "identification/quasi_static.h"
#include "tests/identification/made_record.h"
#include "tests/support/refusal.h"

namespace hystcan::identification::joint_dynamics_test {
namespace {

constexpr double rate_Hz = 5000.0;
const model::Dynamics truth{{500.0, 0.05}, 0.3e-3};

model::Hysteresis hysteresis() {
  return model::Hysteresis({.input_unit = "V",
                            .output_unit = "um",
                            .ascending = {model::Basis::chebyshev, {11.0, 15.0, 1.8, -0.6}, {0.0, 100.0}},
                            .descending = {model::Basis::chebyshev, {13.8, 15.0, -1.0, -0.6}, {0.0, 100.0}},
                            .k_ascending = 0.05,
                            .k_descending = 0.04});
}

/// A triangle with growing and shrinking amplitude, at this many cycles per second, with noise of 0.1 % of
/// the stroke.
Dataset fast_record(double frequency_Hz, int cycles, std::uint64_t seed, double zero = 0.0) {
  const model::Hysteresis model = hysteresis();
  Dataset dataset{"V", "um", {}, {}, {}};
  auto state = model.at_lower_threshold();
  std::vector<double> still;
  const int rows = static_cast<int>(rate_Hz / frequency_Hz * cycles);
  for (int n = 0; n < rows; ++n) {
    const double t = n / rate_Hz, turn = frequency_Hz * t - std::floor(frequency_Hz * t);
    const double part = 1.0 - std::abs(2.0 * turn - 1.0);
    const int cycle = static_cast<int>(frequency_Hz * t);
    const double low = 6.0 * (cycle % 7), high = 100.0 - 5.0 * (cycle % 5);
    dataset.time_s.push_back(t);
    dataset.input.push_back(cycle == 0 ? 100.0 * part : low * (1.0 - part) + high * part);
    still.push_back(model.advance(state, dataset.input.back()).value);
  }
  dataset.output = respond(truth, dataset.time_s, still);
  for (double& x : dataset.output) x += zero;
  return with_noise(dataset, 0.03, seed);
}

/// A known order of the curves makes the fit faster.
IdentifyOptions of_order_3() {
  IdentifyOptions options;
  options.shape = CurveShape::polynomial(3);
  return options;
}

void expect_truth(const Identified& found) {
  ASSERT_TRUE(found.dynamics);
  EXPECT_NEAR(found.dynamics->mode.natural_frequency_Hz, 500.0, 5.0);
  EXPECT_NEAR(found.dynamics->mode.damping_ratio, 0.05, 0.005);
  EXPECT_NEAR(found.dynamics->delay_s, 0.3e-3, 5e-6);
  EXPECT_LT(100.0 * found.overall.rms / found.output_span, 0.13);
}

TEST(IdentifyDynamics, FindsModeAndDelayBesideTheHysteresis) {
  const std::vector<Dataset> datasets{fast_record(5.0, 8, 1), fast_record(60.0, 60, 2)};
  const Identified plain = identify(datasets, {});
  const Identified found = identify_dynamics(datasets, {});
  std::printf("quasi-static %.3f %%, with dynamics %.4f %%: %.2f Hz, %.4f, %.4f ms, k %.4f %.4f\n",
              100.0 * plain.overall.rms / plain.output_span, 100.0 * found.overall.rms / found.output_span,
              found.dynamics->mode.natural_frequency_Hz, found.dynamics->mode.damping_ratio,
              1e3 * found.dynamics->delay_s, found.parameters.k_ascending, found.parameters.k_descending);
  expect_truth(found);
  EXPECT_NEAR(found.parameters.k_ascending, 0.05, 0.05 * 0.05);
  EXPECT_NEAR(found.parameters.k_descending, 0.04, 0.05 * 0.04);
  EXPECT_GT(plain.overall.rms, 3.0 * found.overall.rms);
}

TEST(IdentifyDynamics, FindsModeAndDelayFromASingleFastRecord) {
  const Identified found = identify_dynamics({fast_record(60.0, 50, 3)}, of_order_3());
  std::printf("%.4f %%: %.2f Hz, %.4f, %.4f ms\n", 100.0 * found.overall.rms / found.output_span,
              found.dynamics->mode.natural_frequency_Hz, found.dynamics->mode.damping_ratio,
              1e3 * found.dynamics->delay_s);
  expect_truth(found);
}

TEST(IdentifyDynamics, KeepsTheZeroOfEachDataset) {
  const Identified found =
      identify_dynamics({fast_record(20.0, 15, 4), fast_record(60.0, 50, 5, 1.5)}, of_order_3());
  expect_truth(found);
  EXPECT_NEAR(found.offsets[1], 1.5, 0.015);
}

TEST(IdentifyDynamics, PredictsItsDatasetWithTheReportedError) {
  const std::vector<Dataset> datasets{fast_record(60.0, 60, 6)};
  const Identified found = identify_dynamics(datasets, of_order_3());
  EXPECT_EQ(ErrorNorms::of(predict(found, datasets, 0), datasets[0].output).rms, found.errors[0].rms);
}

TEST(IdentifyDynamics, UsesAKnownDelay) {
  IdentifyOptions options = of_order_3();
  options.delay_s = 0.3e-3;
  const Identified found = identify_dynamics({fast_record(60.0, 60, 7)}, options);
  EXPECT_EQ(found.dynamics->delay_s, 0.3e-3);
  expect_truth(found);
}

std::string refusal(const std::vector<Dataset>& datasets) {
  return support::refusal_of<std::invalid_argument>([&] { identify_dynamics(datasets, {}); });
}

TEST(IdentifyDynamics, RefusesASlowRecord) {
  const Dataset dense = fast_record(0.5, 5, 8);
  Dataset slow{"V", "um", {}, {}, {}};
  for (std::size_t i = 0; i < dense.size(); i += 50) {
    slow.time_s.push_back(dense.time_s[i]);
    slow.input.push_back(dense.input[i]);
    slow.output.push_back(dense.output[i]);
  }
  EXPECT_EQ(refusal({slow}).substr(0, 24), "no dataset shows a mode:");
}

TEST(IdentifyDynamics, NamesADatasetWithUnevenSamples) {
  Dataset uneven = fast_record(60.0, 60, 9);
  for (std::size_t i = 0; i < uneven.time_s.size(); ++i)
    uneven.time_s[i] += 5e-5 * std::sin(static_cast<double>(i));
  EXPECT_EQ(refusal({fast_record(60.0, 60, 10), uneven}).substr(0, 10), "dataset 2:");
}

TEST(QuasiStatic, ChangeBeforeTheDynamicsCausesThatChangeAfterThem) {
  std::vector<double> time_s, change;
  for (int n = 0; n < 4000; ++n) {
    time_s.push_back(n / rate_Hz);
    change.push_back(std::exp(-1e-5 * (n - 2000.0) * (n - 2000.0)) * std::cos(0.05 * n));
  }
  const std::vector<double> answer = respond(truth, time_s, before_dynamics(truth, time_s, change));
  for (std::size_t i = 0; i < change.size(); ++i) EXPECT_NEAR(answer[i], change[i], 1e-3);
}

}  // namespace
}  // namespace hystcan::identification::joint_dynamics_test
