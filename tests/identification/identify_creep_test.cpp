// Identification of a creeping actuator, from datasets with a known truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <vector>

#include "identification/identify.h"
#include "identification/quasi_static.h"
#include "model/output_creep.h"
#include "model/prandtl_ishlinskii.h"
#include "tests/identification/made_record.h"
#include "tests/model/models.h"

namespace hystcan::identification::identify_creep_test {
namespace {

using model::Hysteresis;
using model::OutputCreep;

constexpr double step_s = 2e-5;
constexpr std::size_t late = 12;  // steps: a delay of 0.24 ms

/// Ten cycles of an actuator that rested at the lower threshold: over the range, then nested, with one row
/// per `stride` steps.
Dataset decaying_sines(double rate_Hz, std::size_t stride, const OutputCreep& creep, double zero,
                       std::uint64_t seed) {
  const Hysteresis truth(model::piezo_model());
  const model::Interval range = truth.input_range();
  model::HysteresisState memory = truth.at_lower_threshold();
  std::vector<double> time_s, inputs, outputs;
  const auto steps = static_cast<std::size_t>(10.0 / (rate_Hz * step_s));
  for (std::size_t i = 0; i < steps; ++i) {
    time_s.push_back(step_s * static_cast<double>(i));
    const double turns = rate_Hz * time_s.back(), reach = std::min(1.0, 1.2 - turns / 10.0);
    inputs.push_back(range.lo +
                     0.5 * range.span() * (1.0 - reach * std::cos(2.0 * std::numbers::pi * turns)));
    outputs.push_back(truth.advance(memory, inputs.back()).value);
  }
  outputs = with_creep(creep, time_s, std::move(outputs));
  Dataset dataset{"V", "um", {}, {}, {}};
  for (std::size_t i = 0; i < steps; i += stride) {
    dataset.time_s.push_back(time_s[i]);
    dataset.input.push_back(inputs[i]);
    dataset.output.push_back(zero + outputs[i < late ? 0 : i - late]);
  }
  return with_noise(dataset, 1e-3 * span_of(dataset.output), seed);
}

std::vector<Dataset> two_rates(const OutputCreep& creep) {
  return {decaying_sines(2.0, 25, creep, 0.0, 1), decaying_sines(20.0, 5, creep, 1.5, 2)};
}

// Some relaxor ceramics creep by this amount. The range of creep ends at the value for which half of the
// output would be immediate.
TEST(IdentifyCreep, FindsFifteenPercentPerDecadeWithItsRange) {
  const Identified found = identify(two_rates(OutputCreep({.per_decade = 0.15})), {});
  ASSERT_TRUE(found.creep);
  EXPECT_NEAR(found.creep->per_decade, 0.15, 0.005);
  ASSERT_TRUE(found.creep_range);
  EXPECT_LE(found.creep_range->hi, most_creep_per_decade);
}

// Without a separate gain, the faster session looks as if the slower one crept.
TEST(IdentifyCreep, ReportsAnAlternativeIfASessionGainExplainsAsMuch) {
  std::vector<Dataset> sessions = two_rates(OutputCreep());
  for (double& x : sessions[0].output) x *= 1.01;
  const Identified found = identify(sessions, {});
  ASSERT_TRUE(found.creep);
  ASSERT_TRUE(found.gains_instead);
  std::printf("creep %.2f %% a decade (0), or a gain of %.4f (0.9901)\n", 100.0 * found.creep->per_decade,
              found.gains_instead->gains[1]);
  EXPECT_NEAR(found.gains_instead->gains[1], 1.0 / 1.01, 1e-3);
  EXPECT_LT(found.gains_instead->rms, 1.1 * found.gains_instead->rms_with_creep);
}

TEST(IdentifyCreep, ReportsNoAlternativeIfNoGainExplainsIt) {
  const Identified found = identify(two_rates(OutputCreep({.per_decade = 0.02})), {});
  ASSERT_TRUE(found.creep);
  EXPECT_FALSE(found.gains_instead);
}

TEST(IdentifyCreep, FindsCreepDelayAndKFromTwoRates) {
  const Identified found = identify(two_rates(OutputCreep({.per_decade = 0.02})), {});
  ASSERT_TRUE(found.creep);
  std::printf(
      "creep %.3f %% a decade (2), delay %.4f ms (0.24), k %.4f and %.4f (0.05, 0.04), zero %.3f (1.5)\n",
      100.0 * found.creep->per_decade, 1e3 * found.delay_s, found.parameters.k_ascending,
      found.parameters.k_descending, found.offsets[1]);
  EXPECT_NEAR(found.creep->per_decade, 0.02, 0.002);
  EXPECT_NEAR(found.delay_s, 0.24e-3, 10e-6);
  EXPECT_NEAR(found.parameters.k_ascending, 0.05, 0.03 * 0.05);
  EXPECT_NEAR(found.parameters.k_descending, 0.04, 0.03 * 0.04);
  EXPECT_LT(found.creep_range->lo, 0.02);
  EXPECT_GT(found.creep_range->hi, 0.02);
}

TEST(IdentifyCreep, FindsNoneIfThereIsNone) {
  const Identified found = identify(two_rates(OutputCreep()), {});
  EXPECT_FALSE(found.creep);
  EXPECT_NEAR(found.delay_s, 0.24e-3, 10e-6);
}

TEST(IdentifyCreep, UsesTheGivenCreepForASingleRecord) {
  const OutputCreep creep({.per_decade = 0.02});
  IdentifyOptions options;
  options.creep_per_decade = 0.02;
  const Identified found = identify({decaying_sines(20.0, 5, creep, 0.0, 3)}, options);
  EXPECT_EQ(found.creep->per_decade, 0.02);
  EXPECT_LT(found.overall.rms, 1.1e-3 * found.output_span);
}

// One session has a sensor gain 2 % above the others.
TEST(IdentifyCreep, ShowsTheDeviatingRecordByLeavingItOut) {
  std::vector<Dataset> datasets = two_rates(OutputCreep());
  datasets.push_back(decaying_sines(5.0, 10, OutputCreep(), 0.0, 4));
  for (double& output : datasets.back().output) output *= 1.02;
  IdentifyOptions options;
  options.common_gain = true;
  const Identified found = identify(datasets, options);
  ASSERT_EQ(found.left_out.size(), 3U);
  EXPECT_NEAR(found.left_out[2].gain, 1.02, 0.005);
  EXPECT_GT(found.left_out[2].rms(), 1.3 * found.left_out[0].rms());
}

/// Twenty plays with a bent output, initially at rest, along straight lines between turning points.
Dataset plays_along(const std::vector<double>& turns, double speed_per_s, double row_s, double zero,
                    std::uint64_t seed) {
  model::PrandtlIshlinskiiParameters parameters{"V", "um", {0.0, 100.0}, 0.0, 0.2, {}, {}};
  for (int i = 1; i <= 20; ++i) {
    parameters.thresholds.push_back(2.0 * i);
    parameters.weights.push_back(0.01 * (1 + i % 3));
  }
  const model::PrandtlIshlinskii truth(parameters);
  Dataset dataset = record_of(truth, truth.virgin(0.0), travelled(turns, speed_per_s * row_s));
  const double full = std::ranges::max(dataset.output);
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    dataset.time_s[i] = row_s * static_cast<double>(i);
    const double part = dataset.output[i] / full;
    dataset.output[i] *= 1.0 + 0.24 * part - 0.08 * part * part;
  }
  const std::vector<double> crept =
      with_creep(OutputCreep({.per_decade = 0.02}), dataset.time_s, dataset.output);
  const double late_rows = 4e-4 / row_s;
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    const double at = std::max(0.0, static_cast<double>(i) - late_rows);
    const auto before = static_cast<std::size_t>(at);
    const double share = at - static_cast<double>(before);
    dataset.output[i] = crept[before] + (share > 0.0 ? share * (crept[before + 1] - crept[before]) : 0.0);
  }
  for (double& output : dataset.output) output += zero;
  return with_noise(dataset, 2e-4 * span_of(dataset.output), seed);
}

// No model of this kind is exact, and neither session contains all turning points of the other one.
TEST(IdentifyCreep, FindsCreepInEitherOrderOfTwoRecords) {
  const Dataset slow = plays_along({0, 97, 5, 92, 10, 87, 15, 82, 20, 77, 25, 72, 30, 67, 35, 62, 40, 57},
                                   250.0, 2e-3, -0.2, 7);
  const Dataset fast = plays_along({0,  100, 0,  30, 14, 38, 21, 64, 32, 41, 2,  55, 8, 90, 40, 55, 43, 79,
                                    59, 76,  55, 78, 64, 97, 34, 72, 45, 57, 46, 56, 6, 79, 15, 38, 24, 40},
                                   3000.0, 2e-4, 0.3, 8);
  const Identified one = identify({slow, fast}, {}), other = identify({fast, slow}, {});
  ASSERT_TRUE(one.creep && other.creep);
  std::printf("creep %.2f and %.2f %%\n", 100.0 * one.creep->per_decade, 100.0 * other.creep->per_decade);
  EXPECT_GT(one.creep->per_decade, 0.005);
  EXPECT_NEAR(one.creep->per_decade, other.creep->per_decade, 0.002);
}

}  // namespace
}  // namespace hystcan::identification::identify_creep_test
