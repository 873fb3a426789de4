#include "identification/old_model.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "tests/identification/made_record.h"
#include "tests/support/piezo.h"

namespace hystcan::identification::old_model_test {
namespace {

constexpr double noise_um = 0.003;  // 0.01 % of the stroke

const model::Hysteresis& piezo() {
  static const model::Hysteresis model(support::piezo_model());
  return model;
}

/// Loops between 40 and 60 % of the range.
Dataset small_loops() {
  const model::Interval range = piezo().input_range();
  const std::vector<double> parts{0.5, 0.6, 0.4, 0.6, 0.45, 0.55, 0.4, 0.6, 0.5, 0.55, 0.4};
  return with_noise(record_of(piezo(), piezo().at_lower_threshold(),
                              travelled(in_range(parts, range), range.span() / 200.0)),
                    noise_um, 1);
}

/// RMS in um over the loops of the whole range.
double miss_of(const Identified& identified) {
  const Dataset all = record_of(piezo(), 75.0);
  return ErrorNorms::of(predict(model::Hysteresis(identified.parameters), all, Lag{},
                                {.kind = InitialMemory::Kind::from_lower}),
                        all.output)
      .rms;
}

TEST(IdentifyFrom, KeepsTheOldModelBeyondTheInputs) {
  const Identified found = identify_from({support::piezo_model()}, {small_loops()}, {});
  EXPECT_LT(miss_of(found), 0.03) << "um, of 30";
  EXPECT_GT(miss_of(identify({small_loops()}, {})), 1.0) << "without it";
}

TEST(IdentifyFrom, CountsTheOldModelInNoFigure) {
  const std::vector<Dataset> datasets{small_loops(), small_loops()};
  const Identified found = identify_from({support::piezo_model()}, datasets, {});
  for (const std::size_t size :
       {found.memories.size(), found.offsets.size(), found.gains.size(), found.drifts.size(),
        found.datasets.size(), found.errors.size(), found.folds.of.size()})
    EXPECT_EQ(size, 2U);
  EXPECT_NEAR(found.overall.rms, noise_um, 0.1 * noise_um);
  EXPECT_LT(found.output_span, 10.0) << "um: that of the small loops";
}

// 10 ms between samples.
TEST(IdentifyFrom, KeepsTheDelayThatItsSamplesDoNotShow) {
  constexpr std::size_t thinned = 10, late = 5;
  const Dataset fine = record_of(piezo(), 400.0);
  Dataset coarse{"V", "um", {}, {}, {}};
  for (std::size_t i = late; i < fine.size(); i += thinned) {
    coarse.time_s.push_back(fine.time_s[i]);
    coarse.input.push_back(fine.input[i]);
    coarse.output.push_back(fine.output[i - late]);
  }
  EXPECT_EQ(identify({coarse}, {}).delay_s, 0.0);
  EXPECT_EQ(identify_from({support::piezo_model(), 5e-3}, {coarse}, {}).delay_s, 5e-3);
}

TEST(IdentifyFrom, RefusesAButterfly) {
  IdentifyOptions options;
  options.output = ShapeOfOutput::butterfly;
  EXPECT_THROW(identify_from({support::piezo_model()}, {small_loops()}, options), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::identification::old_model_test
