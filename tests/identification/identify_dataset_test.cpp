// Identification from measured datasets, compared with thirty plays fitted to the same data, and from very
// large datasets. Tests with measured datasets are skipped if the files are not available.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "config/files/dataset_file.h"
#include "identification/baselines/baseline_models.h"
#include "identification/baselines/fit_prandtl_ishlinskii.h"
#include "identification/excerpt.h"
#include "identification/identify.h"
#include "identification/prediction.h"
#include "identification/regression.h"
#include "model/hysteresis.h"
#include "tests/identification/made_record.h"
#include "tests/identification/measured.h"
#include "tests/model/models.h"
#include "tests/support/refusal.h"

namespace hystcan::identification::identify_dataset_test {
namespace {

using model::Hysteresis;
using Mask = std::vector<bool>;

constexpr std::size_t plays = 30;

class MeasuredDataset : public testing::Test {
 protected:
  /// Returns false if one of the files does not exist; the test is then skipped.
  bool load(const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      const std::filesystem::path file = measured(name);
      if (!std::filesystem::exists(file)) {
        missing_ = file.string();
        return false;
      }
      datasets.push_back(config::load_dataset(file).dataset);
    }
    return true;
  }
  std::string no_dataset() const { return "no dataset " + missing_ + "; set HYSTCAN_DATA"; }

  std::vector<Dataset> datasets;

 private:
  std::string missing_;
};

Dataset joined(const std::vector<Dataset>& datasets) {
  Dataset all;
  for (const Dataset& dataset : datasets) {
    all.input.insert(all.input.end(), dataset.input.begin(), dataset.input.end());
    all.output.insert(all.output.end(), dataset.output.begin(), dataset.output.end());
  }
  return all;
}

std::vector<double> delayed_input(const Dataset& dataset, double delay_s) {
  const Dataset sequence = Excerpt(dataset, {}, dataset.size(), 0.0).delayed_by(delay_s);
  std::vector<double> inputs;
  for (std::size_t i = 0; i < sequence.input.size(); ++i)
    if (sequence.fold[i] != Regression::left_out) inputs.push_back(sequence.input[i]);
  return inputs;
}

/// Thirty plays, fitted to the `seen` samples of consecutive datasets; the prediction contains all samples.
BaselineModel thirty_plays(const std::vector<Dataset>& datasets, double delay_s, const Mask& seen) {
  Dataset all = joined(datasets);
  all.input.clear();
  for (const Dataset& dataset : datasets) {
    const std::vector<double> inputs = delayed_input(dataset, delay_s);
    all.input.insert(all.input.end(), inputs.begin(), inputs.end());
  }
  std::vector<double> weight(seen.begin(), seen.end());
  const auto [lo, hi] = std::ranges::minmax(all.input);
  return fit_prandtl_ishlinskii({{}, all.input, all.output, weight, {lo, hi}}, plays);
}

// RMS and largest error of the samples in `which`, in percent of the span of all outputs.
ErrorNorms percent_of(const std::vector<double>& predicted, const std::vector<double>& output,
                      const Mask& which) {
  std::vector<double> a, b;
  for (std::size_t i = 0; i < which.size(); ++i)
    if (which[i]) {
      a.push_back(predicted[i]);
      b.push_back(output[i]);
    }
  const ErrorNorms errors = ErrorNorms::of(a, b);
  const double percent = 100.0 / span_of(output);
  return {errors.rms * percent, errors.max * percent};
}

std::vector<double> own_prediction(const Identified& found, const Dataset& dataset, std::size_t i = 0) {
  return predict(Hysteresis(found.parameters), dataset, {found.delay_s}, found.memories[i]);
}

void print_errors(const char* what, const ErrorNorms& ours, std::size_t parameters,
                  const ErrorNorms& baselines) {
  std::printf("%-58s %7.3f %% RMS %7.3f %% max, %zu parameters; %zu plays: %7.3f %% RMS %7.3f %% max, %zu\n",
              what, ours.rms, ours.max, parameters, plays, baselines.rms, baselines.max, plays + 2);
}

// Fits the model and the plays to all samples of one dataset.
Identified fitted_beside_plays(const char* name, const Dataset& dataset, ErrorNorms& ours) {
  const Identified found = identify({dataset}, {});
  const Mask all(dataset.size(), true);
  ours = percent_of(own_prediction(found, dataset), dataset.output, all);
  const BaselineModel baseline = thirty_plays({dataset}, found.delay_s, all);
  print_errors(name, ours, found.parameter_count(), percent_of(baseline.prediction, dataset.output, all));
  return found;
}

class PiezoStage : public MeasuredDataset {};
class LongPiezoStage : public PiezoStage {};

TEST_F(PiezoStage, RisingAmplitudesAreFittedToAQuarterPercent) {
  if (!load({"piezo_stage_rising_20hz"})) GTEST_SKIP() << no_dataset();
  ErrorNorms ours;
  fitted_beside_plays("rising 20 Hz, fitted", datasets[0], ours);
  EXPECT_LE(ours.rms, 0.25);
  EXPECT_LE(ours.max, 0.9);
}

// The input is delayed by one sample.
TEST_F(PiezoStage, IsFittedByThirtyPlaysWithAnErrorOfAboutOnePercent) {
  if (!load({"piezo_stage_rising_20hz"})) GTEST_SKIP() << no_dataset();
  Dataset& dataset = datasets[0];
  std::rotate(dataset.input.begin(), dataset.input.end() - 1, dataset.input.end());
  dataset.input.front() = dataset.input[1];
  const std::vector<double> weight(dataset.size(), 1.0);
  const Samples samples{{}, dataset.input, dataset.output, weight, {-90.0, 90.0}};
  const auto rms_percent = [&](const BaselineModel& baseline) {
    return percent_of(baseline.prediction, dataset.output, Mask(dataset.size(), true)).rms;
  };
  const double of_plays = rms_percent(fit_prandtl_ishlinskii(samples, plays));
  const double of_average = rms_percent(fit_average(samples, 5));
  EXPECT_NEAR(of_plays, 0.9, 0.2);
  EXPECT_GT(of_average, 2.0 * of_plays);
  EXPECT_LT(rms_percent(fit_prandtl_ishlinskii_free_start(samples, plays)), of_plays);
  EXPECT_LT(rms_percent(fit_preisach(samples, 20)), of_average);
}

// Curves of a higher order include those of a lower order. Their error is therefore not larger, even if many
// branches are close to decreasing.
TEST_F(LongPiezoStage, AHigherOrderHasASmallerError) {
  if (!load({"piezo_stage_rising_20hz"})) GTEST_SKIP() << no_dataset();
  const auto rms = [&](int order) {
    IdentifyOptions options;
    options.shape = CurveShape::polynomial(order);
    return identify(datasets, options).overall.rms;
  };
  EXPECT_LT(rms(16), rms(10));
}

TEST_F(PiezoStage, RisingAmplitudesArePredictedFromEverySecondCycle) {
  if (!load({"piezo_stage_rising_20hz"})) GTEST_SKIP() << no_dataset();
  const Dataset& dataset = datasets[0];
  const Folds folds = assign_folds(datasets, {-90.0, 90.0});
  IdentifyOptions options;
  options.unseen.emplace_back();
  Mask seen, unseen;
  for (const int fold : folds.of[0]) unseen.push_back(fold > 0 && fold % 2 == 0);
  for (const bool hidden : unseen) seen.push_back(!hidden);
  options.unseen[0] = unseen;
  const Identified found = identify(datasets, options);
  const ErrorNorms ours = percent_of(own_prediction(found, dataset), dataset.output, unseen);
  const BaselineModel baseline = thirty_plays(datasets, found.delay_s, seen);
  print_errors("rising 20 Hz, unseen cycles", ours, found.parameter_count(),
               percent_of(baseline.prediction, dataset.output, unseen));
  EXPECT_LE(ours.rms, 0.35);
}

// The zeros of the three sessions differ by 0.77 V, a tenth of the stroke.
TEST_F(PiezoStage, ThreeSessionsAtThreeRatesAreFittedTogether) {
  if (!load({"piezo_stage_rising_20hz", "piezo_stage_growing5hz_tri100_1", "piezo_stage_rising_40hz"}))
    GTEST_SKIP() << no_dataset();
  const Identified found = identify(datasets, {});
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    const double percent = 100.0 * found.errors[i].rms / found.output_span;
    std::printf("session %zu of three: %.3f %% RMS, zero %+.3f, delay %.3f ms\n", i + 1, percent,
                found.offsets[i], 1e3 * found.delay_s);
    EXPECT_LE(percent, 0.36);
  }
  EXPECT_NEAR(found.offsets[2], 0.77, 0.02);
  EXPECT_NEAR(1e3 * found.delay_s, 0.115, 0.035);
}

double predicted_percent(const Identified& found, const Dataset& dataset) {
  const MemoryEstimate start =
      estimate_memory(Hysteresis(found.parameters), dataset, found.lag(), dataset.size(), true);
  return 100.0 * start.rms / span_of(dataset.output);
}

TEST_F(LongPiezoStage, EachSessionIsPredictedFromTheOtherTwo) {
  if (!load({"piezo_stage_rising_20hz", "piezo_stage_growing5hz_tri100_1", "piezo_stage_rising_40hz"}))
    GTEST_SKIP() << no_dataset();
  const std::array<double, 3> at_most{0.60, 0.60, 0.48};
  for (std::size_t i = 0; i < 3; ++i) {
    std::vector<Dataset> others = datasets;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const Identified found = identify(others, {});
    ASSERT_TRUE(found.creep);
    const double percent = predicted_percent(found, datasets[i]);
    std::printf("session %zu predicted from the others: %.3f %% RMS, delay %.3f ms, creep %.2f %% a decade\n",
                i + 1, percent, 1e3 * found.delay_s, 100.0 * found.creep->per_decade);
    EXPECT_LE(percent, at_most[i]);
    EXPECT_NEAR(1e3 * found.delay_s, 0.125, 0.045);
  }
}

TEST_F(PiezoStage, AFasterSessionIsPredictedWithAKnownCreep) {
  if (!load({"piezo_stage_rising_20hz", "piezo_stage_rising_40hz"})) GTEST_SKIP() << no_dataset();
  IdentifyOptions options;
  options.creep_per_decade = 0.033;
  const Identified found = identify({datasets[0]}, options);
  const double percent = predicted_percent(found, datasets[1]);
  std::printf("rising 40 Hz, predicted from rising 20 Hz: %.3f %% RMS\n", percent);
  EXPECT_LE(percent, 0.5);
}

TEST_F(PiezoStage, ASlowerSessionIsPredictedWithAKnownDelay) {
  if (!load({"piezo_stage_rising_40hz", "piezo_stage_rising_20hz"})) GTEST_SKIP() << no_dataset();
  IdentifyOptions options;
  options.delay_s = 1e-4;
  const Identified found = identify({datasets[0]}, options);
  const MemoryEstimate start =
      estimate_memory(Hysteresis(found.parameters), datasets[1], {found.delay_s}, datasets[1].size(), true);
  const double percent = 100.0 * start.rms / span_of(datasets[1].output);
  std::printf("rising 20 Hz, predicted from rising 40 Hz: %.3f %% RMS\n", percent);
  EXPECT_LE(percent, 0.5);
}

class Iron : public MeasuredDataset {};

// Nearly all of the output change occurs within 0.1 % of the inputs.
TEST_F(Iron, IsFittedBySplinesWithAnInputMap) {
  if (!load({"iron_bh_sample6_virgin_major"})) GTEST_SKIP() << no_dataset();
  const Identified found = identify(datasets, {});
  const double percent = 100.0 * found.overall.rms / found.output_span;
  std::printf("iron: %s, %.2f %% RMS\n", found.search.shape.text().c_str(), percent);
  EXPECT_TRUE(found.search.shape.input_map);
  EXPECT_LE(percent, 2.0);
}

TEST_F(PiezoStage, GrowingAmplitudesWithAnUnknownHistoryAreFitted) {
  if (!load({"piezo_stage_growing5hz_tri100_1"})) GTEST_SKIP() << no_dataset();
  ErrorNorms ours;
  fitted_beside_plays("growing 5 Hz, fitted", datasets[0], ours);
  EXPECT_LE(ours.rms, 0.28);
}

TEST_F(LongPiezoStage, GrowingAmplitudesArePredictedFromRisingOnes) {
  if (!load({"piezo_stage_rising_20hz", "piezo_stage_growing5hz_tri100_1"})) GTEST_SKIP() << no_dataset();
  const Dataset &rising = datasets[0], &growing = datasets[1];
  const Identified found = identify({rising}, {});
  const Hysteresis model(found.parameters);
  const auto first =
      static_cast<std::size_t>(std::ranges::upper_bound(growing.time_s, 0.25) - growing.time_s.begin());
  const MemoryEstimate start = estimate_memory(model, growing, {found.delay_s}, first, true);
  std::vector<double> predicted = predict(model, growing, {found.delay_s}, start.memory);
  for (double& x : predicted) x += start.offset;
  const Mask all(growing.size(), true);
  const ErrorNorms ours = percent_of(predicted, growing.output, all);

  Mask seen(rising.size() + growing.size(), false);
  std::fill_n(seen.begin(), rising.size(), true);
  const BaselineModel baseline = thirty_plays(datasets, found.delay_s, seen);
  std::vector<double> of_plays(baseline.prediction.end() - std::ssize(growing.output),
                               baseline.prediction.end());
  double offset = 0.0;
  for (std::size_t i = 0; i < first; ++i)
    offset += (growing.output[i] - of_plays[i]) / static_cast<double>(first);
  for (double& x : of_plays) x += offset;
  print_errors("growing 5 Hz, predicted from rising 20 Hz", ours, found.parameter_count(),
               percent_of(of_plays, growing.output, all));
  EXPECT_LE(ours.rms, 0.6);
}

class Quadrupole : public MeasuredDataset {};

// The width of the loop: the span of the difference of the output from a straight line.
double loop_width(const Dataset& dataset) {
  const double count = static_cast<double>(dataset.size());
  double v = 0.0, x = 0.0, vx = 0.0, vv = 0.0;
  for (std::size_t i = 0; i < dataset.size(); ++i)
    v += dataset.input[i] / count, x += dataset.output[i] / count;
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    vx += (dataset.input[i] - v) * (dataset.output[i] - x);
    vv += (dataset.input[i] - v) * (dataset.input[i] - v);
  }
  std::vector<double> left;
  for (std::size_t i = 0; i < dataset.size(); ++i)
    left.push_back(dataset.output[i] - vx / vv * dataset.input[i]);
  return span_of(left);
}

void print_width_error(const char* what, double rms, double width, std::size_t parameters) {
  std::printf("%-58s %7.3f %% RMS of the loop's width, %zu parameters\n", what, 100.0 * rms / width,
              parameters);
}

TEST_F(Quadrupole, EachRunIsFittedToATwentiethOfItsLoop) {
  if (!load({"slac_quad_run3", "slac_quad_run4"})) GTEST_SKIP() << no_dataset();
  for (const Dataset& dataset : datasets) {
    ErrorNorms ours;
    const Identified found = fitted_beside_plays(
        &dataset == &datasets[0] ? "quadrupole run 3, fitted" : "quadrupole run 4, fitted", dataset, ours);
    print_width_error("  the same", found.overall.rms, loop_width(dataset), found.parameter_count());
    EXPECT_LE(found.overall.rms, 0.05 * loop_width(dataset));
  }
}

TEST_F(Quadrupole, TwoRunsAreFittedTogetherAndPredictTheOthers) {
  if (!load({"slac_quad_run3", "slac_quad_run4", "slac_quad_run5", "slac_quad_run6"}))
    GTEST_SKIP() << no_dataset();
  const std::vector<Dataset> fitted{datasets[0], datasets[1]};
  const Identified found = identify(fitted, {});
  for (std::size_t i = 0; i < 2; ++i) {
    print_width_error(i == 0 ? "quadrupole run 3, fitted with 4" : "quadrupole run 4, fitted with 3",
                      found.errors[i].rms, loop_width(datasets[i]), found.parameter_count());
    EXPECT_LE(found.errors[i].rms, 0.05 * loop_width(datasets[i])) << "run " << i + 3;
  }
  const Hysteresis model(found.parameters);
  for (std::size_t i = 2; i < 4; ++i) {
    const Dataset& dataset = datasets[i];
    const MemoryEstimate start = estimate_memory(model, dataset, {found.delay_s}, dataset.size(), false);
    const Mask all(dataset.size(), true);
    const ErrorNorms ours =
        percent_of(predict(model, dataset, {found.delay_s}, start.memory), dataset.output, all);
    Mask seen(datasets[0].size() + datasets[1].size(), true);
    seen.resize(seen.size() + dataset.size(), false);
    const BaselineModel baseline = thirty_plays({datasets[0], datasets[1], dataset}, found.delay_s, seen);
    const std::vector<double> of_plays(baseline.prediction.end() - std::ssize(dataset.output),
                                       baseline.prediction.end());
    const char* name =
        i == 2 ? "quadrupole run 5, predicted from 3 and 4" : "quadrupole run 6, predicted from 3 and 4";
    print_errors(name, ours, found.parameter_count(), percent_of(of_plays, dataset.output, all));
    print_width_error("  the same", start.rms, loop_width(datasets[0]), found.parameter_count());
    EXPECT_LE(start.rms, 0.15 * loop_width(datasets[0])) << "run " << i + 3;
  }
}

class ShapeMemoryWing : public MeasuredDataset {};
class LongShapeMemoryWing : public ShapeMemoryWing {};

TEST_F(LongShapeMemoryWing, IsFittedBySplinesWithAnInputMap) {
  if (!load({"sma_wing_forc_E"})) GTEST_SKIP() << no_dataset();
  const Identified found = identify(datasets, {});
  const double percent = 100.0 * found.overall.rms / found.output_span;
  std::printf("wing: %s, %.2f %% RMS\n", found.search.shape.text().c_str(), percent);
  EXPECT_TRUE(found.search.shape.input_map);
  EXPECT_LE(percent, 3.0);
}

TEST_F(ShapeMemoryWing, UnseenReversalCurvesArePredicted) {
  if (!load({"sma_wing_forc_E"})) GTEST_SKIP() << no_dataset();
  const Dataset& dataset = datasets[0];
  const auto [lo, hi] = std::ranges::minmax(dataset.input);
  Mask unseen(dataset.size(), false), seen;
  std::size_t cycle = 0;
  const auto points = turning_points(dataset, 0.02 * (hi - lo));
  for (std::size_t i = 0, next = 0; i < dataset.size(); ++i) {
    for (; next < points.size() && points[next] < i; ++next)
      if (dataset.input[points[next]] < lo + 0.5 * (hi - lo)) ++cycle;
    unseen[i] = cycle % 2 == 1;
  }
  for (const bool hidden : unseen) seen.push_back(!hidden);
  ASSERT_GE(cycle, 3U);
  IdentifyOptions options;
  options.unseen.push_back(unseen);
  const Identified found = identify(datasets, options);
  const std::vector<double> ours = own_prediction(found, dataset);
  const BaselineModel baseline = thirty_plays(datasets, found.delay_s, seen);
  print_errors("wing, seen reversal curves", percent_of(ours, dataset.output, seen), found.parameter_count(),
               percent_of(baseline.prediction, dataset.output, seen));
  const ErrorNorms on_unseen = percent_of(ours, dataset.output, unseen);
  print_errors("wing, unseen reversal curves", on_unseen, found.parameter_count(),
               percent_of(baseline.prediction, dataset.output, unseen));
  EXPECT_LE(on_unseen.rms, 4.0);
}

TEST(LargeDataset, AHundredThousandSamplesAreFittedAsWellAsAFewThousand) {
  const Hysteresis truth(model::piezo_model());
  const Dataset dataset = record_of(truth, 6200.0);
  ASSERT_GE(dataset.size(), 100'000U);
  const Identified found = identify({with_noise(dataset, 1e-3 * span_of(dataset.output), 8)}, {});
  EXPECT_LT(100.0 * found.overall.rms / found.output_span, 0.13);
  EXPECT_NEAR(found.parameters.k_ascending, 0.05, 0.005);
}

TEST(LargeDataset, WhiteNoiseIsRefused) {
  std::mt19937_64 random(12);
  std::normal_distribution<double> noise;
  Dataset dataset{"V", "um", {}, {}, {}};
  for (int i = 0; i < 100'000; ++i) {
    dataset.time_s.push_back(1e-4 * i);
    dataset.input.push_back(noise(random));
    dataset.output.push_back(noise(random) + 0.01 * dataset.input.back());  // rises very little
  }
  const std::clock_t before = std::clock();
  const std::string refusal = support::refusal_of<std::invalid_argument>([&] { identify({dataset}, {}); });
  EXPECT_NE(refusal.find("the output does not follow the input"), std::string::npos) << refusal;
  std::printf("100000 samples of noise: refused after %.1f s of processor time\n",
              static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
}

}  // namespace
}  // namespace hystcan::identification::identify_dataset_test
