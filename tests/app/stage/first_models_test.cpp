#include "app/stage/first_stage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "config/files/model_file.h"
#include "identification/ascending_choice.h"
#include "identification/separable_fit.h"
#include "model/hysteresis.h"
#include "model/validity.h"

namespace hystcan::app::first_models_test {
namespace {

AxisFacts stage() {
  AxisFacts axis;
  axis.config.wire.drive_unit = "V";
  axis.config.control.gate.drive_min = -20.0;
  axis.config.control.gate.drive_max = 120.0;
  axis.travel_um = {-14.0, 86.0};
  return axis;
}

TEST(FirstModel, IsTheStraightLineThroughTheTravel) {
  const model::HysteresisParameters line = straight_line(stage());
  for (const double v : {-20.0, 0.0, 50.0, 120.0}) {
    EXPECT_NEAR(line.ascending.value(v), -14.0 + 100.0 * (v + 20.0) / 140.0, 1e-12);
    EXPECT_EQ(line.ascending.value(v), line.descending.value(v));
  }
  EXPECT_NO_THROW(model::Hysteresis{line});
}

TEST(FirstPlant, HasALoopOfElevenPercentOverTheWholeTravel) {
  const model::HysteresisParameters loop = usual_loop(stage());
  EXPECT_NO_THROW(model::Hysteresis{loop});
  double widest = 0.0;
  for (double v = -20.0; v <= 120.0; v += 0.5)
    widest = std::max(widest, loop.descending.value(v) - loop.ascending.value(v));
  EXPECT_NEAR(widest, 11.4, 0.1);
  EXPECT_NEAR(loop.ascending.value(-20.0), -14.0, 1e-12);
  EXPECT_NEAR(loop.ascending.value(120.0), 86.0, 1e-12);
}

class MismatchOfShippedModels : public testing::TestWithParam<const char*> {};

TEST_P(MismatchOfShippedModels, IsThreePercentOfTheCurvesAndTwentyOfK) {
  const auto file = std::filesystem::path(HYSTCAN_SOURCE_DIR) / "config" / GetParam();
  const model::HysteresisParameters given = config::load_model(file), other = not_quite(given, 0.03);
  EXPECT_NO_THROW(model::Hysteresis{other});
  const double hi = given.input_range().hi, lo = given.input_range().lo;
  double farthest = 0.0;
  for (double share = 0.0; share <= 1.0; share += 0.01) {
    const double v = lo + share * (hi - lo);
    farthest = std::max(farthest, std::abs(other.ascending.value(v) - given.ascending.value(v)));
  }
  const double percent = 100.0 * farthest / given.output_range().span();
  EXPECT_NEAR(percent, 1.5, 0.01) << "3 % of the way from the middle";
  EXPECT_NEAR(other.k_ascending / given.k_ascending, 1.2, 1e-9);
  EXPECT_NEAR(other.k_descending / given.k_descending, 1.2, 1e-9);
}

TEST(MismatchOfCreep, IsTwentyPercent) {
  const std::optional<model::OutputCreep::Config> given{{.per_decade = 0.02}};
  EXPECT_NEAR(not_quite(given, 0.03)->per_decade, 1.2 * 0.02, 1e-12);
  EXPECT_FALSE(not_quite(std::optional<model::OutputCreep::Config>{}, 0.03));
}

TEST(MismatchOfCreep, StaysWithinTheRangeOfIdentify) {
  const auto other = not_quite(std::optional<model::OutputCreep::Config>{{.per_decade = 0.15}}, 0.1);
  EXPECT_EQ(other->per_decade, identification::most_creep_per_decade);
  EXPECT_NO_THROW(model::OutputCreep{*other});
}

// Records that begin wiped at the lowest drive do not determine the curve; it is chosen as in
// ascending_choice.h.
TEST(MismatchOfACurveFromTheLowerPoint, KeepsTheVirginCurveOnTheAscendingBranch) {
  model::HysteresisParameters given = usual_loop(stage());
  given = identification::with_ascending_from_lower(given, 1e-6);
  ASSERT_TRUE(identification::begins_at_lower_point(given));
  const model::HysteresisParameters other = not_quite(given, 0.05);
  const model::Hysteresis plant(other);
  for (const double v : {-19.0, 0.0, 60.0}) {
    model::HysteresisState from_lower = plant.at_lower_threshold();
    EXPECT_NEAR(plant.virgin(v).output, plant.advance(from_lower, v).value, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Files, MismatchOfShippedModels,
                         testing::Values("piezo.model.toml", "galfenol.model.toml", "soft_stage.model.toml"));

}  // namespace
}  // namespace hystcan::app::first_models_test
