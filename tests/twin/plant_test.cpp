#include "twin/plant.h"

#include <gtest/gtest.h>

#include "tests/twin/stage.h"

namespace hystcan::twin::plant_test {
namespace {

using std::chrono::milliseconds;

Plant::Config config() { return piezo_stage(); }

TEST(Plant, RestsAtItsStart) {
  Plant plant(config(), can::Time{});
  plant.advance_to(can::Time{} + milliseconds(100));
  EXPECT_NEAR(plant.position_um(), 0.0, 1e-14);
  EXPECT_EQ(plant.drive(), 0.0);
}

// A twin answers the first SYNC in time after a weekend of rest; 5e9 sub-steps would take minutes.
TEST(Plant, NeedsNoComputingTimeWhileItRests) {
  Plant plant(config(), can::Time{});
  plant.advance_to(can::Time{} + std::chrono::hours(72));
  plant.set_target(50.0);
  plant.advance_to(can::Time{} + std::chrono::hours(72) + std::chrono::seconds(2));
  const double settled = plant.position_um();
  plant.advance_to(can::Time{} + std::chrono::hours(144));
  EXPECT_NEAR(plant.position_um(), settled, 1e-12);
}

TEST(Plant, SettlesOnTheHysteresisCurve) {
  Plant plant(config(), can::Time{});
  plant.set_target(50.0);
  plant.advance_to(can::Time{} + std::chrono::seconds(1));
  EXPECT_NEAR(plant.position_um(), support::piezo_model().ascending.value(50.0), 1e-9);
}

TEST(Plant, LimitsItsTargetToTheAmplifiersRange) {
  Plant plant(config(), can::Time{});
  plant.set_target(1e6);
  plant.advance_to(can::Time{} + std::chrono::seconds(1));
  EXPECT_NEAR(plant.drive(), 120.0, 1e-9);
}

TEST(Plant, IgnoresATimeInThePast) {
  Plant plant(config(), can::Time{});
  plant.set_target(50.0);
  plant.advance_to(can::Time{} + milliseconds(2));
  const double before = plant.position_um();
  plant.advance_to(can::Time{} + milliseconds(1));
  EXPECT_EQ(plant.position_um(), before);
}

}  // namespace
}  // namespace hystcan::twin::plant_test
