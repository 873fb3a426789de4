// Identification of butterflies with coercivity, with a known truth.
#include "identification/butterfly.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/cubic_spline.h"
#include "tests/identification/made_record.h"
#include "tests/model/models.h"
#include "tests/support/refusal.h"

namespace hystcan::identification::butterfly_test {
namespace {

using model::Hysteresis;
using model::HysteresisParameters;

constexpr double steps = 250.0;  // per range: about 4100 samples
constexpr double noise = 5e-4;   // of the output span
constexpr double limit = 0.15;   // percent of the output span, RMS

constexpr model::Interval range{-100.0, 100.0};

/// m from -1 to 1; at zero input it is 0.3 or -0.3.
HysteresisParameters magnetisation() {
  return {.input_unit = "V",
          .output_unit = "um",
          .ascending = {model::Basis::power, {-0.3, 0.01, 3e-5}, range},
          .descending = {model::Basis::power, {0.3, 0.01, -3e-5}, range},
          .k_ascending = 0.005,
          .k_descending = 0.005};
}

/// Magnetisation that saturates on both sides of a coercive input of 15 V.
HysteresisParameters saturating() {
  std::vector<double> knots;
  for (int i = 0; i <= 16; ++i) knots.push_back(-100.0 + 12.5 * i);
  const auto curve = [&](double coercive) {
    const auto m = [&](double v) { return std::tanh((v - coercive) / 45.0) + 0.01 * v; };
    std::vector<double> coefficients;
    for (const double v : model::greville_points(knots))
      coefficients.push_back(-1.0 + 2.0 * (m(v) - m(-100.0)) / (m(100.0) - m(-100.0)));
    return model::ReferenceCurve(model::CubicSpline(knots, coefficients), range);
  };
  HysteresisParameters p = magnetisation();
  p.ascending = curve(15.0);
  p.descending = curve(-15.0);
  p.k_ascending = p.k_descending = 0.01;
  return p;
}

Hysteresis butterfly(HysteresisParameters p, const std::vector<double>& map) {
  p.output_map.emplace(map, model::Interval{-1.0, 1.0});
  return Hysteresis(std::move(p));
}

Dataset noisy(const Hysteresis& truth, std::uint64_t seed) {
  const Dataset dataset = record_of(truth, steps);
  return with_noise(dataset, noise * span_of(dataset.output), seed);
}

double rms_percent(const Identified& found) { return 100.0 * found.overall.rms / found.output_span; }

void expect_found(const Hysteresis& truth, const char* what) {
  const Identified found = identify({noisy(truth, 1)}, {});
  std::printf("%s: %.4f %% RMS, %s, %zu parameters\n", what, rms_percent(found),
              found.search.shape.text().c_str(), found.parameter_count());
  ASSERT_TRUE(found.parameters.output_map) << what;
  EXPECT_LT(rms_percent(found), limit) << what;
  const Hysteresis model(found.parameters);
  EXPECT_NEAR(model.output_range().lo, truth.output_range().lo, 0.005 * truth.output_range().span());
}

TEST(IdentifyButterfly, FindsASquare) {
  expect_found(butterfly(magnetisation(), {15.0, 0.0, 15.0}), "square");
}

TEST(LongIdentifyButterfly, FindsAnAsymmetricMapOfHigherOrder) {
  expect_found(butterfly(magnetisation(), {14.0, 1.0, 14.0, -0.6, 0.9}), "order 4, not even");
}

TEST(IdentifyButterfly, FindsASaturatingMagnetisation) {
  expect_found(butterfly(saturating(), {15.0, 0.0, 15.0}), "saturating");
}

TEST(IdentifyButterfly, PredictsItsDatasetWithTheReportedError) {
  const Dataset dataset = noisy(butterfly(magnetisation(), {15.0, 0.0, 15.0}), 2);
  const Identified found = identify({dataset}, {});
  const std::vector<double> predicted = predict(found, {dataset}, 0);
  EXPECT_NEAR(ErrorNorms::of(predicted, dataset.output).rms, found.overall.rms, 1e-12);
  EXPECT_NEAR(found.search.rms, found.overall.rms, 0.1 * found.overall.rms) << "errors are of x, not of m";
}

TEST(IdentifyButterfly, FindsTheZeroOfEachDataset) {
  const Hysteresis truth = butterfly(magnetisation(), {15.0, 0.0, 15.0});
  Dataset second = noisy(truth, 3);
  for (double& x : second.output) x += 7.0;
  const Identified found = identify({noisy(truth, 4), second}, {});
  EXPECT_NEAR(found.offsets[1], 7.0, 5e-4 * found.output_span);
  EXPECT_LT(rms_percent(found), limit);
}

TEST(IdentifyButterfly, PrefersTheFoldIfItFitsEquallyWell) {
  HysteresisParameters p = magnetisation();
  p.ascending = p.descending = {model::Basis::power, {0.0, 0.01}, range};
  const Identified found = identify({noisy(butterfly(p, {15.0, 0.0, 15.0}), 5)}, {});
  EXPECT_FALSE(found.parameters.output_map);
  EXPECT_EQ(found.parameters.symmetry, model::Symmetry::even);
}

TEST(IdentifyButterfly, RefusesAOneSidedDataset) {
  const Hysteresis truth = butterfly(magnetisation(), {15.0, 0.0, 15.0});
  const Dataset one_side =
      record_of(truth, truth.at_upper_threshold(),
                travelled({100.0, 0.0, 100.0, 20.0, 90.0, 10.0, 70.0, 30.0, 100.0}, 0.5));
  EXPECT_FALSE(passes_valley(one_side));
  IdentifyOptions options;
  options.output = ShapeOfOutput::butterfly;
  const std::string refusal = support::refusal_of<std::invalid_argument>([&] {
    identify({noisy(truth, 1), one_side}, options);
  });
  EXPECT_NE(refusal.find("dataset 2 shows only one side"), std::string::npos) << refusal;
}

TEST(IdentifyButterfly, FindsNoValleyInARisingOutput) {
  EXPECT_FALSE(passes_valley(record_of(Hysteresis(model::piezo_model()), steps)));
  EXPECT_TRUE(passes_valley(record_of(butterfly(magnetisation(), {15.0, 0.0, 15.0}), steps)));
  EXPECT_FALSE(passes_valley({}));
}

TEST(IdentifyButterfly, FindsNoValleyInANoisyOutputThatHardlyMoves) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise_um(0.0, 1.0);
  Dataset dataset;
  for (int i = 0; i < 10'000; ++i) {
    dataset.time_s.push_back(0.004 * i);
    dataset.input.push_back(-std::min(i, 10'000 - i) * 6e-4);
    dataset.output.push_back(-80.0 * std::min(1.0, i / 8000.0) + noise_um(random));
  }
  EXPECT_FALSE(passes_valley(dataset));
}

TEST(IdentifyButterfly, StopsOnRequest) {
  IdentifyOptions options;
  options.output = ShapeOfOutput::butterfly;
  int calls = 0;
  options.go_on = [&] { return ++calls < 200; };
  const Identified found = identify({noisy(butterfly(magnetisation(), {15.0, 0.0, 15.0}), 1)}, options);
  EXPECT_TRUE(found.stopped);
  EXPECT_LT(calls, 400);
}

}  // namespace
}  // namespace hystcan::identification::butterfly_test
