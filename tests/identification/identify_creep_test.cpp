// Identification of a creeping actuator, from datasets with a known truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <vector>

#include "identification/creep_rows.h"
#include "identification/identify.h"
#include "model/output_creep.h"
#include "tests/identification/made_record.h"
#include "tests/model/models.h"

namespace hystcan::identification::identify_creep_test {
namespace {

using model::Hysteresis;
using model::OutputCreep;

constexpr double step_s = 2e-5;
constexpr std::size_t late = 12;  // steps: a delay of 0.24 ms

/// Ten cycles of an actuator that was at rest at the lower threshold: over the range, then nested. One row in each `stride`
/// steps.
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

TEST(IdentifyCreep, IsFoundFromTwoRatesADecadeApartWithDelayAndK) {
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

TEST(IdentifyCreep, IsNotFoundWhereThereIsNone) {
  const Identified found = identify(two_rates(OutputCreep()), {});
  EXPECT_FALSE(found.creep);
  EXPECT_NEAR(found.delay_s, 0.24e-3, 10e-6);
}

TEST(IdentifyCreep, OfOneRecordIsTheOneThatWasGiven) {
  const OutputCreep creep({.per_decade = 0.02});
  IdentifyOptions options;
  options.creep_per_decade = 0.02;
  const Identified found = identify({decaying_sines(20.0, 5, creep, 0.0, 3)}, options);
  EXPECT_EQ(found.creep->per_decade, 0.02);
  EXPECT_LT(found.overall.rms, 1.1e-3 * found.output_span);
}

// A session whose sensor shows 2 % more than that of the others.
TEST(IdentifyCreep, ARecordThatDisagreesIsFoundByLeavingItOut) {
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

}  // namespace
}  // namespace hystcan::identification::identify_creep_test
