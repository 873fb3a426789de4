// An absolute sensor: a stroke of 30 um far from zero.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "identification/baselines/comparison.h"
#include "identification/determination.h"
#include "identification/identify.h"
#include "model/hysteresis.h"
#include "tests/identification/made_record.h"
#include "tests/support/piezo.h"

namespace hystcan::identification::identify_offset_test {
namespace {

constexpr double noise_um = 1e-3;

Dataset at(double offset_um, std::uint64_t seed = 1) {
  Dataset record = with_noise(record_of(model::Hysteresis(support::piezo_model()), 30.0), noise_um, seed);
  for (double& x : record.output) x += offset_um;
  return record;
}

/// Resolution of outputs near `offset`, as stored.
double resolution(double offset) { return std::abs(offset) * std::numeric_limits<double>::epsilon(); }

TEST(IdentifyOffset, ChangesNothingUpToABillionStrokes) {
  const Identified near = identify({at(0.0)}, {});
  for (const double offset : {40.0, -400.0, 1e4, -1e5, 1e6, 1e7, -1e8, 1e9, 3e10}) {
    SCOPED_TRACE(offset);
    const Identified far = identify({at(offset)}, {});
    const double least = resolution(offset);
    EXPECT_EQ(far.search.shape.text(), near.search.shape.text());
    EXPECT_NEAR(far.parameters.k_ascending, near.parameters.k_ascending, 1e-3 * near.parameters.k_ascending);
    EXPECT_NEAR(far.overall.rms, near.overall.rms, 1e-3 * near.overall.rms + least);
    EXPECT_NEAR(*far.held_out_rms, *near.held_out_rms, 1e-2 * *near.held_out_rms + least);
    EXPECT_NEAR(far.output_span, near.output_span, 1e-9 * near.output_span + 4.0 * least);
    EXPECT_NEAR(far.parameters.ascending.value(50.0) - offset, near.parameters.ascending.value(50.0),
                0.1 * noise_um + 8.0 * least);
  }
}

TEST(IdentifyOffset, EqualsTheZeroOfEachSession) {
  IdentifyOptions one_gain;
  one_gain.common_gain = true;
  const Identified near = identify({at(0.0), at(2.0, 2)}, {}), far = identify({at(0.0), at(1e7, 2)}, {}),
                   both = identify({at(1e7), at(1e7 + 2.0, 2)}, one_gain);
  EXPECT_NEAR(far.offsets[1], 1e7, 0.01);
  EXPECT_NEAR(both.offsets[1], 2.0, 0.01);
  for (const Identified& found : {far, both}) {
    EXPECT_NEAR(found.overall.rms, near.overall.rms, 1e-2 * near.overall.rms);
    EXPECT_NEAR(found.parameters.k_ascending, near.parameters.k_ascending, 1e-3);
  }
}

TEST(IdentifyOffset, ChangesNoComparisonWithOtherModels) {
  const std::vector<Dataset> low{at(0.0)}, high{at(1e7)};
  const Identified near = identify(low, {}), far = identify(high, {});
  const Comparison expected = compare(low, near, [] { return true; }),
                   found = compare(high, far, [] { return true; });
  ASSERT_EQ(found.rows.size(), expected.rows.size());
  for (std::size_t i = 0; i < found.rows.size(); ++i) {
    SCOPED_TRACE(found.rows[i].name);
    EXPECT_NEAR(found.rows[i].fit.rms, expected.rows[i].fit.rms, 0.02 * expected.rows[i].fit.rms);
    EXPECT_NEAR(found.rows[i].held_out->rms, expected.rows[i].held_out->rms,
                0.05 * expected.rows[i].held_out->rms);
  }
  EXPECT_NEAR(landscape(high, far, 3).rms[1][1], landscape(low, near, 3).rms[1][1], 1e-2 * noise_um);
}

}  // namespace
}  // namespace hystcan::identification::identify_offset_test
