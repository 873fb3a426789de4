// The simulated material may be a hysteresis model of any kind.
#include "twin/plant.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/twin/stage.h"

namespace hystcan::twin::material_test {
namespace {

using std::chrono::milliseconds;

constexpr model::Interval range{0.0, 100.0};

model::HysteresisParameters butterfly() {
  model::HysteresisParameters parameters = support::piezo_model();
  parameters.symmetry = model::Symmetry::even;
  return parameters;
}

model::PreisachParameters preisach() {
  return {.input_unit = "V",
          .output_unit = "um",
          .input_range = range,
          .offset = 0.0,
          .gain = 0.2,
          .weights = {1.0, 0.8, 1.2, 0.3, 0.7, 1.5, 0.2, 0.4, 0.8, 1.6}};
}

model::PrandtlIshlinskiiParameters plays() {
  return {.input_unit = "V",
          .output_unit = "um",
          .input_range = range,
          .offset = 1.0,
          .gain = 0.2,
          .thresholds = {5.0, 15.0, 30.0},
          .weights = {0.05, 0.03, 0.02}};
}

/// One model of each kind.
std::vector<model::AnyParameters> kinds() {
  return {support::piezo_model(), model::LinearMappingParameters{support::piezo_model()}, plays(), preisach(),
          butterfly()};
}

/// Targets with nested minor loops; some loops are left through their turning points.
constexpr double excursions[] = {80.0, 20.0, 60.0, 35.0, 50.0, 42.0, 70.0, 10.0, 100.0, 0.0, 55.0, 30.0};

// A motion that is slow compared with amplifier and mode follows the hysteresis model's output.
TEST(SlowLoop, EqualsTheOutputOfTheHysteresisModelForEveryKind) {
  for (const model::AnyParameters& kind : kinds()) {
    Plant::Config config = piezo_stage();
    config.hysteresis = kind;
    config.mode = {.natural_frequency_Hz = 1000.0, .damping_ratio = 1.0};
    Plant plant(config, can::Time{});
    std::visit(
        [&](const auto& model) {
          auto state = model.virgin(0.0);
          can::Time now{};
          for (const double target : excursions) {
            plant.set_target(target);
            plant.advance_to(now += milliseconds(20));  // e^{-125} of the step remains
            EXPECT_NEAR(plant.position_um(), model.advance(state, target).value, 1e-9)
                << model.kind() << " at " << target;
          }
        },
        model::model_of(kind));
  }
}

// Magnetostriction: x(v) = x(-v). Within one sub-step from 60 to -60 the field passes zero, where the
// material has a turning point: its output falls along the outer branch and rises again.
TEST(Butterfly, PassesZeroOnTheWayToTheOtherSign) {
  const model::Hysteresis model(butterfly());
  auto state = model.virgin(0.0);
  Material material(butterfly(), 0.0, 64);
  double before = 0.0;
  for (const double drive : {60.0, -60.0, -20.0, -80.0, 40.0}) {
    if (before * drive < 0.0) model.advance(state, 0.0);
    const double looked_at = material.look_at(drive);
    EXPECT_EQ(looked_at, material.go_to(drive));
    EXPECT_NEAR(material.look_at(drive), model.advance(state, std::abs(drive)).value, 1e-12) << drive;
    before = drive;
  }
}

TEST(Butterfly, IsDrivenThroughBothWingsByThePlant) {
  Plant::Config config = piezo_stage();
  config.hysteresis = butterfly();
  config.amplifier.drive_min = -120.0;
  Plant plant(config, can::Time{});
  plant.set_target(-50.0);
  plant.advance_to(can::Time{} + milliseconds(500));
  EXPECT_NEAR(plant.drive(), -50.0, 1e-9);
  const double left_um = plant.position_um();
  EXPECT_NEAR(left_um, support::piezo_model().ascending.value(50.0), 1e-9);
  plant.set_target(50.0);
  double lowest_um = left_um;
  for (int i = 0; i < 200; ++i) {
    plant.advance_to(can::Time{} + milliseconds(500) + std::chrono::microseconds(10 * i));
    lowest_um = std::min(lowest_um, plant.hysteresis_um());
  }
  EXPECT_LT(lowest_um, 3.0) << "between the wings";
  plant.advance_to(can::Time{} + milliseconds(1000));
  EXPECT_GT(plant.position_um(), 10.0);
}

// The memory contains 4000 nested turning points: on the way out, the output passes each of them again.
TEST(Material, RemembersThousandsOfNestedLoops) {
  Material material(support::piezo_model(), 0.0, 4096);
  std::vector<double> drives, outputs;
  drives.reserve(4000);
  outputs.reserve(4000);
  for (int i = 0; i < 4000; ++i) {
    const double away = 40.0 * (1.0 - i / 4001.0);
    drives.push_back(50.0 + (i % 2 == 0 ? away : -away));
    outputs.push_back(material.go_to(drives.back()));
  }
  for (std::size_t i = drives.size(); i-- > 0;)
    ASSERT_NEAR(material.go_to(drives[i]), outputs[i], 1e-9) << "turning point " << i;
}

TEST(Material, RefusesAnInvalidModel) {
  model::PreisachParameters without_weights = preisach();
  without_weights.weights.pop_back();
  EXPECT_THROW(Material(without_weights, 0.0, 64), std::invalid_argument);
  EXPECT_THROW(Material(plays(), 101.0, 64), std::invalid_argument) << "outside the model's range";
}

}  // namespace
}  // namespace hystcan::twin::material_test
