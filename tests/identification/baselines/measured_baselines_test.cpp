// The baselines on a measured piezo stage. The test is skipped if the dataset is not available.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "config/files/dataset_file.h"
#include "identification/baselines/baseline_models.h"
#include "identification/baselines/fit_prandtl_ishlinskii.h"
#include "tests/identification/measured.h"

namespace hystcan::identification::measured_baselines_test {
namespace {

// RMS error in percent of the output's span.
double rms_percent(const BaselineModel& baseline, const std::vector<double>& output) {
  double sum = 0.0;
  for (std::size_t n = 0; n < output.size(); ++n) sum += std::pow(baseline.prediction.at(n) - output[n], 2);
  const auto [lo, hi] = std::ranges::minmax(output);
  return 100.0 * std::sqrt(sum / static_cast<double>(output.size())) / (hi - lo);
}

TEST(MeasuredPiezoStage, IsFittedByThirtyPlaysWithAnErrorOfAboutOnePercent) {
  const std::filesystem::path file = measured("piezo_stage_rising_20hz");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no dataset " << file << "; set HYSTCAN_DATA";
  Dataset dataset = config::load_dataset(file).dataset;
  std::rotate(dataset.input.begin(), dataset.input.end() - 1, dataset.input.end());  // delayed by one sample
  dataset.input.front() = dataset.input[1];
  const std::vector<double> weight(dataset.size(), 1.0);
  const Samples samples{{}, dataset.input, dataset.output, weight, {-90.0, 90.0}};
  const double average = rms_percent(fit_average(samples, 5), dataset.output);
  const double plays = rms_percent(fit_prandtl_ishlinskii(samples, 30), dataset.output);
  const double free_start = rms_percent(fit_prandtl_ishlinskii_free_start(samples, 30), dataset.output);
  const double relays = rms_percent(fit_preisach(samples, 20), dataset.output);
  RecordProperty("rms_percent_average", std::to_string(average));
  RecordProperty("rms_percent_plays", std::to_string(plays));
  RecordProperty("rms_percent_plays_free_start", std::to_string(free_start));
  RecordProperty("rms_percent_preisach", std::to_string(relays));
  EXPECT_NEAR(plays, 0.9, 0.2);
  EXPECT_GT(average, 2.0 * plays);
  EXPECT_LT(free_start, plays);
  EXPECT_LT(relays, average);
}

}  // namespace
}  // namespace hystcan::identification::measured_baselines_test
