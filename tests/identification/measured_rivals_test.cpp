// The rivals on a measured piezo stage. Skipped where the record is not at hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "config/record_file.h"
#include "identification/rivals.h"
#include "tests/identification/measured.h"

namespace hystcan::identification {
namespace {

// RMS error in percent of the output's span.
double rms_percent(const Rival& rival, const std::vector<double>& output) {
  double sum = 0.0;
  for (std::size_t n = 0; n < output.size(); ++n) sum += std::pow(rival.prediction.at(n) - output[n], 2);
  const auto [lo, hi] = std::ranges::minmax(output);
  return 100.0 * std::sqrt(sum / static_cast<double>(output.size())) / (hi - lo);
}

TEST(MeasuredPiezoStage, PlaysWithAnAssumedStartMissByAboutOnePercent) {
  const std::filesystem::path file = measured("piezo_stage_rising_20hz");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no record " << file << "; set HYSTCAN_DATA";
  Record record = config::load_record(file).record;
  std::rotate(record.input.begin(), record.input.end() - 1, record.input.end());  // delayed by one sample
  record.input.front() = record.input[1];
  const std::vector<double> weight(record.size(), 1.0);
  const Samples samples{{}, record.input, record.output, weight, {-90.0, 90.0}};
  const double average = rms_percent(fit_average(samples, 5), record.output);
  const double plays = rms_percent(fit_prandtl_ishlinskii(samples, 30), record.output);
  const double free_start = rms_percent(fit_prandtl_ishlinskii_free_start(samples, 30), record.output);
  const double relays = rms_percent(fit_preisach(samples, 20), record.output);
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
}  // namespace hystcan::identification
