#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "model/hysteresis.h"
#include "tests/model/models.h"

namespace hystcan::model::inverse_test {
namespace {

double span_of(const Hysteresis& model) { return model.output_range().hi - model.output_range().lo; }

TEST(InverseThenForward, ReturnsTheCommandInsideTheMajorLoop) {
  for (const auto& parameters : {piezo_model(), galfenol_model(), linear_model()}) {
    const Hysteresis model(parameters);
    HysteresisState state = model.at_lower_threshold();
    const double x_lo = model.output_range().lo, span = span_of(model);
    for (int i = 0; i < 2000; ++i) {
      const double t = i / 2000.0;
      const double x = x_lo + span * (0.5 - 0.49 * std::cos(40.0 * t) * std::exp(-2.0 * t));
      const Prediction drive = model.inverse(state, x);
      EXPECT_FALSE(drive.saturated);
      EXPECT_TRUE(drive.increasing);
      EXPECT_NEAR(model.forward(state, drive.value).value, x, 1e-14 * span);
      model.advance(state, drive.value);
    }
  }
}

TEST(InverseThenForward, ReturnsTheCommandOnRandomModelsAndMemories) {
  EXPECT_TRUE(rc::check("the round trip is exact to 1e-12 of the span, without saturation", [] {
    const Hysteresis model(RandomModel::draw());
    HysteresisState state = model.at_lower_threshold();
    for (const double v : random_walk(model.input_range(), 20)) model.advance(state, v);
    for (int i = 0; i < 30; ++i) {
      const double x = model.output_range().lo + span_of(model) * *number(0.0, 1.0);
      const Prediction drive = model.inverse(state, x);
      RC_ASSERT(!drive.saturated);
      if (!drive.increasing) continue;
      RC_ASSERT(std::abs(model.forward(state, drive.value).value - x) <= 1e-12 * span_of(model));
      model.advance(state, drive.value);
    }
  }));
}

TEST(ForwardThenInverse, ReturnsTheInputAndTheSameMemory) {
  EXPECT_TRUE(
      rc::check("two actuators, one driven by the inverse of the other's output, remember the same", [] {
        const Hysteresis model(RandomModel::draw());
        HysteresisState leader = model.at_lower_threshold(), follower = leader;
        for (const double v : random_walk(model.input_range(), 40)) {
          model.advance(leader, v);
          if (!leader.branches.back().increasing) return;
          const Prediction drive = model.inverse(follower, leader.output);
          model.advance(follower, drive.value);
          RC_ASSERT(std::abs(follower.output - leader.output) <= 1e-12 * span_of(model));
          // 1e-9: the slope limits the accuracy of an input that is computed from an output.
          RC_ASSERT(std::abs(follower.input - leader.input) <= 1e-9 * model.input_range().span());
        }
        for (int i = 0; i < 10; ++i) {
          const double v = model.input_range().lo + model.input_range().span() * *number(0.0, 1.0);
          RC_ASSERT(std::abs(model.forward(follower, v).value - model.forward(leader, v).value) <=
                    1e-9 * span_of(model));
        }
      }));
}

TEST(AdvanceByTheResultOfTheInverse, GivesTheMemoryOfItsInput) {
  EXPECT_TRUE(rc::check("the level is exact to 1e-14 of the span, and the next steps are the same", [] {
    const Hysteresis model(RandomModel::draw());
    HysteresisState state = model.at_lower_threshold();
    for (const double v : random_walk(model.input_range(), 20)) model.advance(state, v);
    for (int i = 0; i < 30; ++i) {
      const double x = model.output_range().lo + span_of(model) * *number(0.0, 1.0);
      HysteresisState evaluated = state;
      const FoundInput found = model.inverse(state, x);
      if (!found.increasing) continue;
      model.advance(state, found);
      model.advance(evaluated, found.value);
      RC_ASSERT(state.input == evaluated.input);
      RC_ASSERT(std::abs(state.output - evaluated.output) <= 1e-14 * span_of(model));
      RC_ASSERT(state.depth() == evaluated.depth());
    }
  }));
}

TEST(Inverse, ReturnsTheInputOfATurningPointForItsOutput) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.at_lower_threshold();
  for (const double v : nested_swings(model.input_range(), 12)) model.advance(state, v);
  for (const Branch& branch : state.branches)
    EXPECT_EQ(model.inverse(state, branch.start_level).value, branch.start_input);
}

TEST(Inverse, SaturatesForAnOutputOutOfReach) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.at_lower_threshold();
  model.advance(state, 50.0);
  EXPECT_EQ(model.inverse(state, 31.0).value, 100.0);
  EXPECT_TRUE(model.inverse(state, 31.0).saturated);
  EXPECT_EQ(model.inverse(state, 0.1).value, 0.0);
  EXPECT_TRUE(model.inverse(state, 0.1).saturated);
  EXPECT_EQ(model.inverse(state, model.output_range().hi).value, 100.0);
  EXPECT_FALSE(model.inverse(state, model.output_range().hi).saturated);
  EXPECT_EQ(model.inverse(state, model.output_range().lo).value, 0.0);
  EXPECT_FALSE(model.inverse(state, model.output_range().lo).saturated);
}

TEST(Inverse, ReturnsThePresentInputForThePresentOutput) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.at_lower_threshold();
  for (const double v : {70.0, 20.0, 45.0}) {
    model.advance(state, v);
    EXPECT_EQ(model.inverse(state, state.output).value, v);
  }
}

TEST(Inverse, FollowsTheVirginCurveBelowTheLowerConvergencePoint) {
  const Hysteresis model(linear_model());  // L_0 = (0 V, 1.5 um), f_0^A = 0.2 um/V
  const HysteresisState state = model.virgin(0.0);
  EXPECT_NEAR(model.inverse(state, 0.6).value, 3.0, 1e-13);
  EXPECT_FALSE(model.inverse(state, 0.6).saturated);
  EXPECT_TRUE(model.inverse(state, -0.1).saturated);
}

TEST(Inverse, WorksWithAFullMemory) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.at_lower_threshold(4);
  for (const double v : nested_swings(model.input_range(), 20)) model.advance(state, v);
  for (const double x : {15.0, 14.0, 16.0, 13.0, 18.0, 12.0, 25.0, 5.0}) {
    const double v = model.inverse(state, x).value;
    EXPECT_NEAR(model.advance(state, v).value, x, 3e-14 * 30.0);
  }
}

TEST(Inverse, IsFoundNearAFlatOrigin) {
  HysteresisParameters parameters = galfenol_model();
  parameters.ascending = parameters.descending = ReferenceCurve(Basis::power, {0.0, 0.0, 2.0}, {0.0, 3.0});
  const Hysteresis model(parameters);
  HysteresisState state = model.virgin(3.0);
  for (const double v : {1e-3, 1e-6, 0.5, 2.9})
    EXPECT_NEAR(model.inverse(state, 2.0 * v * v).value, v, 1e-14 / v);
}

}  // namespace
}  // namespace hystcan::model::inverse_test
