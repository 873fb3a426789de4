#include "model/hysteresis_operator.h"

#include <gtest/gtest.h>

#include "tests/model/models.h"

namespace hystcan::model::simulation_test {
namespace {

TEST(Simulation, StartsOnTheAscendingReferenceCurve) {
  const Hysteresis model(piezo_model());
  Simulation forward(model, model.virgin(0.0)), inverse(model, model.virgin(0.0));
  const double x = model.parameters().ascending.value(37.0);
  EXPECT_EQ(forward.follow_input(37.0).output, x);
  EXPECT_NEAR(inverse.follow_output(x).input, 37.0, 1e-12);
}

TEST(Simulation, ReturnsTheInputsWhenItFollowsTheOutputs) {
  const Hysteresis model(piezo_model());
  Simulation forward(model, model.virgin(0.0)), inverse(model, model.virgin(0.0));
  for (const double v : {60.0, 20.0, 45.0, 30.0, 80.0, 10.0, 90.0}) {
    const Row row = forward.follow_input(v);
    EXPECT_EQ(row.input, v);
    const Row back = inverse.follow_output(row.output);
    EXPECT_NEAR(back.input, v, 1e-11);
    EXPECT_NEAR(back.output, row.output, 1e-13);
  }
  EXPECT_EQ(forward.tally().rows, 7u);
  EXPECT_EQ(forward.tally().saturated, 0u);
}

TEST(Simulation, CountsSaturatedAndNotIncreasingRows) {
  const Hysteresis model(linear_model());
  Simulation run(model, model.virgin(0.0));
  run.follow_input(5.0);
  run.follow_input(3.0);  // falls towards L_0, which lies higher: a defect of the virgin curve
  EXPECT_EQ(run.tally().not_increasing, 1u);
  run.follow_input(120.0);
  EXPECT_EQ(run.tally().saturated, 1u);
  EXPECT_EQ(run.follow_output(25.0).input, 100.0);
  EXPECT_EQ(run.follow_output(-3.0).output, 1.5);
  EXPECT_EQ(run.tally().saturated, 3u);
  EXPECT_EQ(run.tally().rows, 5u);
}

}  // namespace
}  // namespace hystcan::model::simulation_test
