// Rows that no stage can produce are found in damaged records, and in no good record.
#include "identification/suspect_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "config/files/dataset_file.h"
#include "model/hysteresis.h"
#include "tests/identification/made_record.h"
#include "tests/identification/measured.h"
#include "tests/model/models.h"

namespace hystcan::identification::suspect_rows_test {
namespace {

Dataset made(const std::vector<double>& inputs, double (*output)(double)) {
  Dataset dataset{"V", "um", {}, inputs, {}};
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    dataset.time_s.push_back(1e-3 * static_cast<double>(i));
    dataset.output.push_back(output(inputs[i]));
  }
  return dataset;
}

bool is_believed(const Dataset& dataset) {
  return suspect_rows(dataset).empty() && sensor_ends(dataset).empty();
}

TEST(SuspectRows, AreNotFoundInMeasuredRecords) {
  const std::vector<std::string> names{"iron_bh_sample6_virgin_major",
                                       "piezo_150v_1hz",
                                       "piezo_stage_growing5hz_tri100_1",
                                       "piezo_stage_rising_20hz",
                                       "sma_wing_forc_E",
                                       "piezo_stage_rising_40hz",
                                       "pnzt_disp_1000v",
                                       "pnzt_disp_1500v",
                                       "slac_quad_run3",
                                       "slac_quad_run4",
                                       "slac_quad_run5",
                                       "slac_quad_run6",
                                       "stages/quant60_loops",
                                       "stages/quant60_step"};
  for (const std::string& name : names) {
    const std::filesystem::path file = measured(name);
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "no dataset " << file << "; set HYSTCAN_DATA";
    EXPECT_TRUE(is_believed(config::load_dataset(file).dataset)) << name;
  }
}

TEST(SuspectRows, AreNotFoundInTheStagesOfTheTests) {
  const std::filesystem::path folder = HYSTCAN_SOURCE_DIR "/tests/app/stages";
  for (const char* name : {"creep30_loops.csv", "quant60_loops.csv", "quant60_step.csv"})
    EXPECT_TRUE(is_believed(config::load_dataset(folder / name).dataset)) << name;
}

TEST(SuspectRows, AreNotFoundInLoopsWithNoise) {
  const Dataset loops = record_of(model::Hysteresis(model::piezo_model()), 75.0);
  for (const double share : {0.0, 1e-4, 1e-3, 1e-2, 0.05})
    for (std::uint64_t seed = 1; seed <= 5; ++seed)
      EXPECT_TRUE(suspect_rows(with_noise(loops, share * span_of(loops.output), seed)).empty())
          << share << ", seed " << seed;
}

TEST(SuspectRows, AreNotFoundInPulsesOfTheExcitation) {
  std::vector<double> inputs(3000, 0.0);
  for (std::size_t i = 75; i < inputs.size(); i += 150) inputs[i] = 20.0;
  EXPECT_TRUE(suspect_rows(made(inputs, [](double v) { return 0.3 * v; })).empty());
}

TEST(SuspectRows, AreNotFoundInShortSteps) {
  std::vector<double> inputs;
  for (int i = 0; i < 240; ++i) inputs.push_back(5.0 * std::abs((i / 6) % 20 - 10));
  inputs.resize(600, 50.0);
  EXPECT_TRUE(is_believed(made(inputs, [](double v) { return 0.3 * v; })));
}

TEST(SuspectRows, AreNotFoundInARingingMode) {
  Dataset steps{"V", "um", {}, {}, {}};
  double x = 0.0, speed = 0.0;
  constexpr double dt = 5e-5, omega = 2.0 * std::numbers::pi * 400.0;
  for (int i = 0; i < 2000; ++i) {
    steps.time_s.push_back(1e-3 * i);
    steps.input.push_back(i / 200 % 2 == 1 ? 5.0 : 0.0);
    steps.output.push_back(x);
    for (int substep = 0; substep < 20; ++substep) {
      speed += (omega * omega * (0.3 * steps.input.back() - x) - 0.1 * omega * speed) * dt;
      x += speed * dt;
    }
  }
  EXPECT_TRUE(is_believed(steps));
}

TEST(SensorEnds, AreNotFoundInACoarseMaterialSaturation) {
  std::vector<double> inputs;
  for (int i = 0; i < 1200; ++i) inputs.push_back(50.0 + 50.0 * std::sin(i / 12.0));
  EXPECT_TRUE(sensor_ends(made(inputs, [](double v) {
                return std::round(150.0 * std::tanh((v - 50.0) / 10.0)) / 10.0;
              })).empty());
  EXPECT_TRUE(sensor_ends(made(inputs,
                               [](double v) {  // the valley of a butterfly
                                 return std::round((v - 50.0) * (v - 50.0) / 10.0) / 10.0;
                               }))
                  .empty());
}

TEST(SameRows, AreFoundInAPartButNotInAnotherSession) {
  const Dataset loops = with_noise(record_of(model::Hysteresis(model::piezo_model()), 75.0), 1e-3, 1);
  Dataset part = loops, faster = loops;
  for (auto* column : {&part.time_s, &part.input, &part.output})
    column->erase(column->begin(), column->begin() + 100);
  for (double& t : faster.time_s) t *= 0.5;
  EXPECT_TRUE(has_same_rows(loops, loops));
  EXPECT_TRUE(has_same_rows(part, loops));
  EXPECT_FALSE(has_same_rows(loops, faster));
  EXPECT_FALSE(has_same_rows(loops, with_noise(loops, 1e-3, 2)));
}

}  // namespace
}  // namespace hystcan::identification::suspect_rows_test
