#include "config/files/actuator.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/model/models.h"

namespace hystcan::config::actuator_test {
namespace {

Actuator actuator(const model::HysteresisParameters& parameters) {
  return Actuator::of(model::Hysteresis(parameters), "model.toml");
}

TEST(Actuator, StartsOnTheAscendingReferenceCurve) {
  const Actuator piezo = actuator(model::piezo_model());
  const double x = model::piezo_model().ascending.value(37.0);
  EXPECT_EQ(piezo.memory().simulate(std::vector{37.0}, {}).outputs.front(), x);
  EXPECT_NEAR(piezo.memory().inverse(std::vector{x}, {}, 1.0).inputs.front(), 37.0, 1e-12);
}

TEST(Actuator, ReturnsTheInputsForItsOutputs) {
  const Actuator piezo = actuator(model::piezo_model());
  const std::vector<double> inputs{60.0, 20.0, 45.0, 30.0, 80.0, 10.0, 90.0};
  const Pass forward = piezo.memory().simulate(inputs, {});
  const Pass back = piezo.memory().inverse(forward.outputs, {}, 1.0);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    EXPECT_NEAR(back.inputs[i], inputs[i], 1e-11);
    EXPECT_NEAR(back.outputs[i], forward.outputs[i], 1e-13);
  }
  EXPECT_EQ(forward.tally.rows, 7u);
  EXPECT_EQ(forward.tally.saturated, 0u);
}

TEST(Actuator, CountsSaturatedAndNotIncreasingRows) {
  ActuatorMemory memory = actuator(model::linear_model()).memory();
  // The branch falls towards the higher point L_0: a defect of the virgin curve.
  EXPECT_EQ(memory.simulate(std::vector{5.0, 3.0}, {}).tally.not_increasing, 1u);
  EXPECT_EQ(memory.simulate(std::vector{120.0}, {}).tally.saturated, 1u);
  const Pass back = memory.inverse(std::vector{25.0, -3.0}, {}, 1.0);
  EXPECT_EQ(back.inputs.front(), 100.0);
  EXPECT_EQ(back.outputs.back(), 1.5);
  EXPECT_EQ(back.tally.saturated, 2u);
}

}  // namespace
}  // namespace hystcan::config::actuator_test
