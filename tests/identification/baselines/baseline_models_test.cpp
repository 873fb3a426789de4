#include "identification/baselines/baseline_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "identification/baselines/fit_linear_mapping.h"
#include "identification/baselines/fit_prandtl_ishlinskii.h"
#include "model/hysteresis.h"
#include "model/linear_mapping.h"
#include "model/prandtl_ishlinskii.h"
#include "model/preisach.h"

namespace hystcan::identification::baseline_models_test {
namespace {

using Numbers = std::vector<double>;

constexpr model::Interval range{0.0, 100.0};

// Swings of varying height from 40 V: minor loops at many places. By the end they reach both thresholds.
Numbers swings(int samples = 3000) {
  Numbers input;
  for (int n = 0; n < samples; ++n) {
    const double t = static_cast<double>(n) / samples, height = 50.5 * std::min(1.0, 0.25 + t);
    const double centre = 50.0 - 10.0 * std::cos(14.0 * t) * (1.0 - height / 50.5);
    const double v = centre + height * std::sin(2.0 * std::numbers::pi * 23.0 * t - 0.2);
    input.push_back(std::clamp(v, range.lo, range.hi));
  }
  return input;
}

model::HysteresisParameters curves(double bend) {
  return {"V",
          "um",
          {model::Basis::power, {0.0, 0.222 - bend, 0.00102 + 0.01 * bend, -2.4e-06}, range},
          {model::Basis::power, {1.5, 0.357 - bend, -0.00048 + 0.01 * bend, -2.4e-06}, range},
          0.035,
          0.035,
          model::Symmetry::none};
}

// A dataset with its weights, which are all one by default.
struct Case {
  Numbers input;
  Numbers output;
  Numbers weight = Numbers(input.size(), 1.0);
  Numbers prehistory;

  template <class Model>
  Case(const Model& truth, typename Model::State state, Numbers inputs = swings())
      : input(std::move(inputs)) {
    for (const double v : input) output.push_back(truth.advance(state, v).value);
  }
  Samples samples() const { return {prehistory, input, output, weight, range}; }
  double span() const { return *std::ranges::max_element(output) - *std::ranges::min_element(output); }
  double largest_error(const BaselineModel& baseline) const {
    double error = 0.0;
    for (std::size_t n = 0; n < output.size(); ++n)
      error = std::max(error, std::abs(baseline.prediction.at(n) - output[n]));
    return error / span();
  }
};

const model::PrandtlIshlinskii& plays() {
  static const model::PrandtlIshlinskii truth({"V",
                                               "um",
                                               range,
                                               2.0,
                                               0.1,
                                               {5, 10, 15, 20, 25, 30, 35, 40, 45},
                                               {0.03, 0.02, 0.0, 0.02, 0.01, 0.0, 0.015, 0.01, 0.005}});
  return truth;
}

model::Preisach relays() {
  return model::Preisach({"V", "um", range, 1.0, 0.05, {2, 1, 3, 0, 1, 4, 0.5, 0, 1, 2}});
}

Case case_of_plays() { return {plays(), plays().virgin(swings().front())}; }
Case case_of_relays() { return {relays(), relays().at_upper_threshold()}; }
Case case_of_recursion() {
  const model::Hysteresis truth(curves(0.0));
  return {truth, truth.at_lower_threshold()};
}

const std::vector<std::function<BaselineModel(const Samples&)>>& every_fit() {
  static const std::vector<std::function<BaselineModel(const Samples&)>> fits{
      [](const Samples& s) { return fit_average(s, 3); },
      [](const Samples& s) { return fit_linear_mapping(s, curves(0.02)); },
      [](const Samples& s) { return fit_prandtl_ishlinskii(s, 9); },
      [](const Samples& s) { return fit_prandtl_ishlinskii_free_start(s, 9); },
      [](const Samples& s) { return fit_preisach(s, 8); }};
  return fits;
}

TEST(AverageModel, FindsAPolynomial) {
  Case made = case_of_plays();
  for (std::size_t n = 0; n < made.input.size(); ++n) {
    const double v = made.input[n];
    made.output[n] = 1.0 + 0.3 * v - 1e-3 * v * v + 1e-5 * v * v * v;
  }
  EXPECT_LT(made.largest_error(fit_average(made.samples(), 3)), 1e-12);  // rounding
  EXPECT_GT(made.largest_error(fit_average(made.samples(), 2)), 1e-3);
}

TEST(LinearMappingFit, FindsTheTrueCurvesFromNearbyStartCurves) {
  const model::LinearMapping truth(curves(0.0));
  for (const auto& state :
       {truth.at_lower_threshold(), truth.at_upper_threshold(), truth.virgin(swings().front())}) {
    const Case made(truth, state);
    EXPECT_GT(made.largest_error({"", 0, Case(model::LinearMapping(curves(0.02)), state).output}), 1e-3);
    EXPECT_LT(made.largest_error(fit_linear_mapping(made.samples(), curves(0.02))), 1e-12);  // rounding
  }
}

TEST(LinearMappingFit, FoldsTheInputIfSymmetryIsEven) {
  model::HysteresisParameters even = curves(0.0), start = curves(0.02);
  even.symmetry = start.symmetry = model::Symmetry::even;
  const model::LinearMapping truth(even);
  Case made(truth, truth.at_lower_threshold());
  for (std::size_t n = 1; n < made.input.size(); ++n)
    if (n % 2 == 0) made.input[n] = -made.input[n];
  EXPECT_LT(made.largest_error(fit_linear_mapping(made.samples(), start)), 1e-12);  // rounding
}

TEST(LinearMappingFit, StaysValidIfTheDatasetNeedsCurvesThatCross) {
  Case made = case_of_plays();
  for (std::size_t n = 0; n < made.input.size(); ++n) made.output[n] = 2.0 * made.input[n] - made.output[n];
  const BaselineModel baseline =
      fit_linear_mapping(made.samples(), curves(0.0));  // throws if the curves are not valid
  EXPECT_LT(made.largest_error(baseline), 0.25);
}

TEST(PrandtlIshlinskiiFit, FindsTheTrueWeightsAfterEachOfTheHistories) {
  std::vector<model::PlayState> starts{plays().virgin(swings().front()), plays().virgin(0.0),
                                       plays().virgin(0.0)};
  for (const double v : {100.0, 0.0}) plays().advance(starts[1], v);
  plays().advance(starts[2], 100.0);
  for (const model::PlayState& start : starts) {
    const Case made(plays(), start);
    EXPECT_LT(made.largest_error(fit_prandtl_ishlinskii(made.samples(), 9)), 1e-12);  // rounding
  }
}

TEST(PrandtlIshlinskiiFit, UsesTheGivenPrehistoryIfItFitsBest) {
  model::PlayState state = plays().virgin(0.0);
  const Numbers before{0.0, 80.0, 10.0, 60.0, 30.0};
  for (const double v : before) plays().advance(state, v);
  Case made(plays(), state);
  const double without = made.largest_error(fit_prandtl_ishlinskii(made.samples(), 9));
  made.prehistory = before;
  EXPECT_LT(made.largest_error(fit_prandtl_ishlinskii(made.samples(), 9)), 1e-8 * without);
}

TEST(PrandtlIshlinskiiFit, FindsTheInitialPlaysIfTheyAreFree) {
  model::PlayState state = plays().virgin(0.0);
  for (const double v : {80.0, 10.0, 60.0, 30.0}) plays().advance(state, v);
  const Case made(plays(), state);
  const Samples samples = made.samples();
  EXPECT_LT(made.largest_error(fit_prandtl_ishlinskii_free_start(samples, 9)), 1e-10);
  EXPECT_GT(made.largest_error(fit_prandtl_ishlinskii(samples, 9)), 1e-3);
}

// Only 5000 samples are fitted, and few of them are turning points.
TEST(PrandtlIshlinskiiFit, UsesAllTurningPointsOfALongDataset) {
  const Case made(plays(), plays().virgin(swings().front()), swings(17'001));
  EXPECT_LT(made.largest_error(fit_prandtl_ishlinskii(made.samples(), 9)), 1e-12);
  EXPECT_LT(made.largest_error(fit_prandtl_ishlinskii_free_start(made.samples(), 9)), 1e-10);
}

TEST(PreisachFit, FindsTheTrueWeights) {
  const Case made = case_of_relays();
  EXPECT_LT(made.largest_error(fit_preisach(made.samples(), 4)), 1e-11);
  EXPECT_GT(made.largest_error(fit_preisach(made.samples(), 3)), 1e-3);
}

TEST(Baselines, HaveLargerErrorsOnATruthOfAnotherClass) {
  const Case recursion = case_of_recursion();
  for (const auto& fit : every_fit()) EXPECT_GT(recursion.largest_error(fit(recursion.samples())), 1e-4);
  const Case made = case_of_relays();
  EXPECT_GT(made.largest_error(fit_prandtl_ishlinskii(made.samples(), 9)), 1e-3);
  EXPECT_GT(made.largest_error(fit_average(made.samples(), 9)), 1e-2);
}

TEST(Baselines, IgnoreSamplesOfWeightZeroButRememberTheirInput) {
  Case made = case_of_recursion();
  for (std::size_t n = 500; n < 1500; ++n) made.weight[n] = 0.0;
  Case spoilt = made;
  for (std::size_t n = 500; n < 1500; ++n) spoilt.output[n] = 1e6;
  for (const auto& fit : every_fit())
    EXPECT_EQ(fit(made.samples()).prediction, fit(spoilt.samples()).prediction);
}

TEST(Baselines, CountTheFittedNumbers) {
  const Case made = case_of_recursion();
  std::vector<BaselineModel> all;
  for (const FitBaseline& fit : every_baseline()) all.push_back(fit(made.samples(), curves(0.0)));
  ASSERT_EQ(all.size(), 6U);
  const std::vector<std::size_t> expected{4, 7, 11, 32, 62, 212};
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].parameters, expected[i]) << all[i].name;
    EXPECT_EQ(all[i].prediction.size(), made.input.size()) << all[i].name;
    EXPECT_LT(made.largest_error(all[i]), 0.1) << all[i].name;
  }
}

TEST(Baselines, RefuseInconsistentSamples) {
  const Case good = case_of_plays();
  for (const auto& fit : every_fit()) {
    Case shorter = good, infinite = good, held_out = good, negative = good;
    shorter.output.pop_back();
    infinite.input[3] = std::numeric_limits<double>::infinity();
    held_out.weight.assign(held_out.weight.size(), 0.0);
    negative.weight[0] = -1.0;
    for (const Case* bad : {&shorter, &infinite, &held_out, &negative})
      EXPECT_THROW(fit(bad->samples()), std::invalid_argument);
    Samples backwards = good.samples();
    backwards.range = {1.0, 1.0};
    EXPECT_THROW(fit(backwards), std::invalid_argument);
  }
}

}  // namespace
}  // namespace hystcan::identification::baseline_models_test
