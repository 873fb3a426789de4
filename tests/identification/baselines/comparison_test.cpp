#include "identification/baselines/comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "model/hysteresis.h"
#include "model/prandtl_ishlinskii.h"

namespace hystcan::identification::comparison_test {
namespace {

using Numbers = std::vector<double>;

constexpr model::Interval range{0.0, 100.0};
constexpr int half_cycle_samples = 40;  // too few for a search of the delay

// Half waves between these turning points. The first cycle reaches both ends of the range; the others differ.
const Numbers turns{0, 100, 0, 80, 20, 95, 5, 60, 30, 100, 10, 70, 0, 90, 40, 85, 15, 65, 0, 100, 0};

Dataset travelled(const Numbers& through) {
  Dataset dataset{"V", "um", {}, {}, {}};
  for (std::size_t j = 0; j + 1 < through.size(); ++j)
    for (int i = 0; i < half_cycle_samples; ++i) {
      const double t = std::numbers::pi * i / half_cycle_samples;
      dataset.time_s.push_back(1e-3 * static_cast<double>(dataset.size()));
      dataset.input.push_back(through[j] + (through[j + 1] - through[j]) * 0.5 * (1.0 - std::cos(t)));
    }
  return dataset;
}

model::HysteresisParameters truth_parameters() {
  return {"V",
          "um",
          {model::Basis::power, {0.0, 0.222, 0.00102, -2.4e-06}, range},
          {model::Basis::power, {1.5, 0.357, -0.00048, -2.4e-06}, range},
          0.035,
          0.03,
          model::Symmetry::none};
}

template <class Model>
Dataset response_of(Dataset dataset, const Model& truth, typename Model::State state) {
  for (const double v : dataset.input) dataset.output.push_back(truth.advance(state, v).value);
  return dataset;
}

// A dataset with noise of 0.02 um, 0.07 % of the span.
Dataset noisy_dataset() {
  const model::Hysteresis truth(truth_parameters());
  Dataset dataset = response_of(travelled(turns), truth, truth.at_lower_threshold());
  std::mt19937 random(7);
  for (double& x : dataset.output) x += 0.02 * (2.0 * static_cast<double>(random()) / 4294967295.0 - 1.0);
  return dataset;
}

IdentifyOptions order_3() {
  IdentifyOptions options;
  options.shape = CurveShape::polynomial(3);
  options.observed_thresholds = true;
  options.go_on = [] { return true; };
  return options;
}

const std::vector<Dataset>& datasets() {
  static const std::vector<Dataset> one{noisy_dataset()};
  return one;
}
const Identified& identified() {
  static const Identified found = identify(datasets(), order_3());
  return found;
}
const Comparison& comparison() {
  static const Comparison made = compare(datasets(), identified(), [] { return true; });
  return made;
}

TEST(Comparison, GivesTheModelOfTheTruthTheSmallestErrors) {
  ASSERT_EQ(comparison().rows.size(), 7U);
  const ComparisonRow& own = comparison().rows.front();
  ASSERT_TRUE(own.held_out.has_value());
  EXPECT_LT(own.held_out->rms, 0.02);  // the RMS of the noise is 0.02 um / sqrt 3
  for (std::size_t i = 1; i < comparison().rows.size(); ++i) {
    const ComparisonRow& baseline = comparison().rows[i];
    EXPECT_LT(own.fit.rms, baseline.fit.rms) << baseline.name;
    ASSERT_TRUE(baseline.held_out.has_value()) << baseline.name;
    EXPECT_LT(own.held_out->rms, baseline.held_out->rms) << baseline.name;
    EXPECT_GE(baseline.held_out->max, baseline.held_out->rms) << baseline.name;
  }
}

TEST(Comparison, CountsParametersAndHeldOutSamples) {
  std::vector<std::size_t> parameters;
  for (const ComparisonRow& row : comparison().rows) parameters.push_back(row.parameters);
  // 2 n + 1 of the curves and two k; n + 1; 2 n + 1; m + 2; m + 2; 2 m + 2; N (N + 1) / 2 + 2
  EXPECT_EQ(parameters, (std::vector<std::size_t>{9, 4, 7, 11, 32, 62, 212}));
  EXPECT_EQ(comparison().samples, datasets().front().size());
  EXPECT_EQ(comparison().cycles, 10U);
  EXPECT_GE(comparison().held_out_cycles, 4U);
  EXPECT_LE(comparison().held_out_cycles, 5U);
  const auto held_out = held_out_samples(identified().folds);
  const auto counted = static_cast<std::size_t>(std::ranges::count(held_out.front(), true));
  EXPECT_EQ(comparison().held_out_samples, counted);
  EXPECT_EQ(comparison().output_span, identified().output_span);
}

TEST(Comparison, ReportsTheErrorsOfTheIdentification) {
  EXPECT_EQ(comparison().rows.front().fit.rms, identified().overall.rms);
  EXPECT_EQ(comparison().rows.front().fit.max, identified().overall.max);
}

// A fit that used the shifted samples would move towards them.
TEST(Comparison, FitsNoModelToHeldOutSamples) {
  std::vector<Dataset> shifted = datasets();
  const double shift = 0.1 * identified().output_span;
  const auto held_out = held_out_samples(identified().folds);
  for (std::size_t i = 0; i < shifted.front().size(); ++i)
    if (held_out.front()[i]) shifted.front().output[i] += shift;
  const Comparison made = compare(shifted, identified(), [] { return true; });
  for (std::size_t i = 0; i < made.rows.size(); ++i) {
    const double before = comparison().rows[i].held_out->rms;
    ASSERT_TRUE(made.rows[i].held_out.has_value());
    // | |e + shift| - shift | <= |e|
    // The search may end at another point; the tolerance for this is a hundredth of the shift.
    EXPECT_NEAR(made.rows[i].held_out->rms, shift, before + 0.01 * shift) << made.rows[i].name;
  }
}

TEST(Comparison, GivesTheReasonIfNothingIsHeldOut) {
  const model::Hysteresis truth(truth_parameters());
  const std::vector<Dataset> one{response_of(travelled({0, 100, 0}), truth, truth.at_lower_threshold())};
  const Comparison made = compare(one, identify(one, order_3()), [] { return true; });
  EXPECT_NE(made.no_hold_out.value_or("").find("too few cycles"), std::string::npos)
      << made.no_hold_out.value_or("");
  EXPECT_EQ(made.held_out_samples, 0U);
  EXPECT_EQ(made.rows.size(), 7U);
  for (const ComparisonRow& row : made.rows) EXPECT_FALSE(row.held_out.has_value()) << row.name;
}

// The truth has plays at the thresholds of the fit. The fit finds them to rounding if every sample of both
// datasets has the right memory.
TEST(Comparison, DrivesTheBaselinesToTheInitialMemoryOfTheNextDataset) {
  const model::PrandtlIshlinskii truth({"V",
                                        "um",
                                        range,
                                        2.0,
                                        0.1,
                                        {5, 10, 15, 20, 25, 30, 35, 40, 45},
                                        {0.03, 0.02, 0.0, 0.02, 0.01, 0.0, 0.015, 0.01, 0.005}});
  model::PlayState start = truth.virgin(0.0);
  for (const double v : {100.0, 0.0}) truth.advance(start, v);
  const std::vector<Dataset> two{response_of(travelled({0, 100, 20, 90, 30, 60}), truth, start),
                                 response_of(travelled({40, 70, 10, 100, 30}), truth, start)};
  IdentifyOptions options = order_3();
  options.common_zero = true;
  const Identified found = identify(two, options);
  ASSERT_EQ(found.memories[1].kind, InitialMemory::Kind::from_lower);
  const Comparison made = compare(two, found, [] { return true; });
  EXPECT_EQ(made.samples, two[0].size() + two[1].size());
  EXPECT_LT(made.rows[3].fit.max, 1e-9 * made.output_span) << made.rows[3].name;
}

TEST(Comparison, FoldsTheInputsOfAllModelsIfTheTruthIsEven) {
  model::HysteresisParameters even = truth_parameters();
  even.symmetry = model::Symmetry::even;
  const model::Hysteresis truth(even);
  const std::vector<Dataset> butterfly{response_of(
      travelled({0, 100, -100, 90, -80, 100, -60, 95, -100, 70, -85, 0}), truth, truth.at_lower_threshold())};
  const Identified found = identify(butterfly, order_3());
  ASSERT_EQ(found.parameters.symmetry, model::Symmetry::even);
  for (const ComparisonRow& row : compare(butterfly, found, [] { return true; }).rows)
    EXPECT_LT(row.fit.rms, 0.05 * found.output_span) << row.name;  // without folding: at least 20 %
}

TEST(Comparison, KeepsTheFinishedRowsWhenStopped) {
  int left = 2;
  const Comparison made = compare(datasets(), identified(), [&] { return left-- > 0; });
  EXPECT_TRUE(made.stopped);
  EXPECT_EQ(made.rows.size(), 2U);
  EXPECT_NE(made.no_hold_out.value_or("").find("stopped"), std::string::npos)
      << made.no_hold_out.value_or("");
  EXPECT_FALSE(made.rows.front().held_out.has_value());
}

}  // namespace
}  // namespace hystcan::identification::comparison_test
