#include "model/hysteresis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "model/hysteresis_parameters.h"
#include "model/linear_mapping.h"
#include "tests/model/models.h"
#include "tests/model/oracle.h"

namespace hystcan::model::hysteresis_test {
namespace {

constexpr double rounding_um = 1e-13;  // a few ulps of 20 um

// f_A = 0.2 v, f_D = 1.5 + 0.185 v, k = 0: g is linear. Every branch is a straight line from its start to its
// target, so that the whole table can be calculated manually.
TEST(Hysteresis, AgreesWithAManualTableForStraightLines) {
  const Hysteresis model(linear_model(0.0));
  HysteresisState state = model.virgin(0.0);
  EXPECT_EQ(state.output, 0.0);
  const std::vector<std::pair<double, double>> table{
      {50.0, 10.0},   // virgin curve
      {30.0, 6.6},    // towards L_0 = (0, 1.5): 10 - 8.5 * 20 / 50
      {40.0, 8.3},    // rises towards (50, 10)
      {35.0, 7.45},   // towards (30, 6.6)
      {30.0, 6.6},    // loop closed
      {10.0, 3.2},    // continues towards L_0
      {60.0, 12.0},   // past (50, 10), the virgin curve again
      {0.0, 1.5},     // L_0: everything is wiped out
      {40.0, 8.9},    // towards U_0 = (100, 20) from L_0
      {100.0, 20.0},  // U_0
      {20.0, 5.2},    // the descending reference curve
      {60.0, 12.6},   // towards U_0 from (20, 5.2)
  };
  for (const auto& [v, x] : table) {
    EXPECT_NEAR(model.forward(state, v).value, x, rounding_um) << "before " << v;
    EXPECT_NEAR(model.advance(state, v).value, x, rounding_um) << "at " << v;
  }
}

// Manual evaluation of eq. 4, k = 0.05:
//   g(s; S) = (e^{0.05 s} - 1) / (e^{0.05 S} - 1)
TEST(Hysteresis, FollowsThePrintedEquationForStraightLines) {
  const Hysteresis model(linear_model(0.05));
  HysteresisState state = model.virgin(0.0);
  model.advance(state, 50.0);
  const auto g = [](double s, double whole) {
    return (std::exp(0.05 * s) - 1.0) / (std::exp(0.05 * whole) - 1.0);
  };
  const double at_30 = 1.5 + 0.185 * 30.0 + (10.0 - 10.75) * g(30.0, 50.0);
  EXPECT_NEAR(model.advance(state, 30.0).value, at_30, rounding_um);
  EXPECT_NEAR(at_30, 6.8164862, 1e-7);
  const double at_40 = 0.2 * 40.0 + (at_30 - 6.0) * g(10.0, 20.0);
  EXPECT_NEAR(model.advance(state, 40.0).value, at_40, rounding_um);
}

TEST(Hysteresis, ClearsItsMemoryAtAThreshold) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.virgin(0.0);
  for (const double v : nested_swings(model.input_range(), 20)) model.advance(state, v);
  EXPECT_GT(state.depth(), 15u);
  HysteresisState low = state, high = state;
  EXPECT_EQ(model.advance(low, 0.0).value, model.output_range().lo);
  EXPECT_EQ(model.advance(high, 100.0).value, model.output_range().hi);
  EXPECT_EQ(low.depth(), 1u);
  EXPECT_EQ(low.direction(), Direction::ascending);
  EXPECT_EQ(high.depth(), 1u);
  EXPECT_EQ(high.direction(), Direction::descending);
  for (const double v : {70.0, 20.0, 45.0, 44.0}) {
    HysteresisState fresh_low = model.at_lower_threshold(), fresh_high = model.at_upper_threshold();
    EXPECT_EQ(model.advance(low, v).value, model.forward(fresh_low, v).value);
    EXPECT_EQ(model.advance(high, v).value, model.forward(fresh_high, v).value);
    model.advance(low, 0.0);
    model.advance(high, 100.0);
  }
}

TEST(Hysteresis, SaturatesBeyondAThresholdAndReportsIt) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.virgin(40.0);
  EXPECT_EQ(model.forward(state, 130.0).value, model.output_range().hi);
  EXPECT_TRUE(model.forward(state, 130.0).saturated);
  EXPECT_FALSE(model.forward(state, 100.0).saturated);
  EXPECT_EQ(model.forward(state, -1.0).value, model.output_range().lo);
  EXPECT_TRUE(model.forward(state, -1.0).saturated);
  EXPECT_TRUE(model.advance(state, 130.0).saturated);
  EXPECT_EQ(state.input, 100.0);
  EXPECT_TRUE(model.advance(state, 131.0).saturated);
  EXPECT_EQ(state.output, model.output_range().hi);
}

TEST(Hysteresis, KeepsItsMemoryWhenTheInputIsNotFinite) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.virgin(0.0);
  for (const double v : {60.0, 30.0, 50.0}) model.advance(state, v);
  const double present = state.output;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(std::isnan(model.forward(state, bad).value));
    EXPECT_FALSE(model.forward(state, bad).finite);
    EXPECT_TRUE(std::isnan(model.inverse(state, bad).value));
    EXPECT_FALSE(model.inverse(state, bad).finite);
    EXPECT_EQ(model.advance(state, bad).value, present);
    EXPECT_FALSE(model.advance(state, bad).finite);
    EXPECT_EQ(state.input, 50.0);
    EXPECT_EQ(state.output, present);
    EXPECT_EQ(state.depth(), 3u);
  }
}

TEST(Hysteresis, DoesNotChangeInAStepToThePresentInput) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.virgin(0.0);
  for (const double v : {60.0, 30.0, 50.0}) model.advance(state, v);
  const double present = state.output;
  EXPECT_EQ(model.advance(state, 50.0).value, present);
  EXPECT_EQ(state.depth(), 3u);
  HysteresisState virgin = model.virgin(0.0);
  EXPECT_EQ(model.advance(virgin, 0.0).value, 0.0);  // still virgin: only a fall reaches L_0
  EXPECT_EQ(model.advance(virgin, 10.0).value, model.parameters().ascending.value(10.0));
}

TEST(Hysteresis, IgnoresTheSignOfTheInputIfSymmetryIsEven) {
  const Hysteresis model(galfenol_model());
  HysteresisState positive = model.virgin(0.0), negative = model.virgin(0.0), mixed = model.virgin(-0.0);
  double sign = 1.0;
  for (const double v : {1.0, 0.4, 2.0, 1.5, 1.7, 3.5, 0.9, 0.0, 1.2}) {
    const double x = model.advance(positive, v).value;
    EXPECT_EQ(model.advance(negative, -v).value, x);
    EXPECT_EQ(model.advance(mixed, sign * v).value, x);
    EXPECT_EQ(model.forward(positive, -v).value, x);
    EXPECT_GE(model.inverse(positive, x - 0.1).value, 0.0);
    sign = -sign;
  }
}

TEST(Hysteresis, HasNoMemoryIfTheLoopHasNoWidth) {
  HysteresisParameters parameters = piezo_model();
  parameters.descending = parameters.ascending;
  parameters.k_ascending = parameters.k_descending = 1000.0;
  const Hysteresis model(parameters);
  HysteresisState state = model.virgin(0.0);
  for (const double v : {60.0, 30.0, 50.0, 49.0, 49.0 + 1e-13, 48.0, 99.0, 0.0, 7.0}) {
    EXPECT_NEAR(model.advance(state, v).value, parameters.ascending.value(v), rounding_um);
    EXPECT_NEAR(model.forward(state, 52.0).value, parameters.ascending.value(52.0), rounding_um);
  }
}

TEST(AverageModel, IsTheMeanOfTheTwoCurvesAfterEveryHistory) {
  const HysteresisParameters p = piezo_model();
  const Hysteresis model(average(p));
  HysteresisState state = model.virgin(0.0);
  for (const double v : {80.0, 20.0, 60.0, 0.0, 100.0, 33.0}) {
    EXPECT_NEAR(model.advance(state, v).value, 0.5 * (p.ascending.value(v) + p.descending.value(v)), 1e-13);
    EXPECT_NEAR(model.inverse(state, 0.5 * (p.ascending.value(50.0) + p.descending.value(50.0))).value, 50.0,
                1e-12);
  }
}

// In a loop a few ulps wide the two sides differ by less than the rounding of the outputs.
TEST(Hysteresis, StaysIncreasingInTinyLoops) {
  const Hysteresis model(piezo_model());
  for (const double size : {1e-3, 1e-6, 1e-9, 1e-11, 1e-12, 1e-13}) {
    for (double v = 5.0; v < 98.0; v += 0.37) {
      HysteresisState state = model.at_lower_threshold();
      for (const double input : {99.0, v, v + size, v + 0.3 * size, v + 0.7 * size})
        EXPECT_TRUE(model.advance(state, input).increasing) << "loop of " << size << " V at " << v;
      // S is at most the difference of the reference curves' slopes plus k times their distance.
      EXPECT_LT(std::abs(state.branches.back().coefficient), 0.5) << "loop of " << size << " V at " << v;
      EXPECT_TRUE(model.inverse(state, state.output + 1.0).increasing);
    }
  }
}

// A controller that holds a position makes steps of ulps in both directions for a whole weekend.
template <class Model>
void stays_finite_in_steps_of_ulps(const Model& model) {
  HysteresisState state = model.at_lower_threshold();
  std::mt19937_64 random(7);
  for (double v = 0.001; v < 99.0; v *= 1.01) {
    model.advance(state, v);
    for (int i = 0; i < 40; ++i) {
      double next = state.input;
      for (auto ulps = random() % 4; ulps > 0; --ulps)
        next = std::nextafter(next, random() % 2 ? 100.0 : 0.0);
      const double before = state.output;
      const double reached = model.advance(state, next).value;
      ASSERT_NEAR(reached, before, 1e-13) << "at " << v;
      const double wanted = reached + 1e-3;
      ASSERT_NEAR(model.forward(state, model.inverse(state, wanted).value).value, wanted, 1e-12)
          << "at " << v;
    }
  }
}

TEST(Hysteresis, StaysFiniteAndInvertibleInStepsOfUlps) {
  stays_finite_in_steps_of_ulps(Hysteresis(piezo_model()));
}

TEST(LinearMapping, StaysFiniteAndInvertibleInStepsOfUlps) {
  stays_finite_in_steps_of_ulps(LinearMapping(piezo_model()));
}

TEST(Hysteresis, StaysFiniteInDenormalStepsFromTheVirginState) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.virgin(0.0);
  for (const double v : {1e-300, 5e-301, 5e-324, 0.0, 1e-310, 1e-12})
    EXPECT_TRUE(std::isfinite(model.advance(state, v).value)) << v;
}

// f_A' = 0.05 + 0.1 (v - 5)^2 on [0, 10]. The loop is 0.9 um wide at the bottom and narrower above. The
// branch from L_0 falls only between its ends, from 4.4 to 5.6 V.
TEST(Hysteresis, FlagsABranchThatDipsBetweenItsEnds) {
  const Interval range{0.0, 10.0};
  const Hysteresis model = Hysteresis::beyond_limit(
      {"V", "um", ReferenceCurve(Basis::power, {0, 2.55, -0.5, 0.1 / 3}, range),
       ReferenceCurve(Basis::power, {0.9, 2.19, -0.446, 0.1 / 3 - 0.0036, 9e-5}, range), 0.0, 0.0,
       Symmetry::none});
  HysteresisState state = model.at_lower_threshold();
  EXPECT_LT(model.forward(state, 5.5).value, model.forward(state, 4.5).value);
  EXPECT_FALSE(model.advance(state, 1.0).increasing);
}

TEST(Inverse, KeepsThePresentInputForALowerOutputOnTheVirginCurve) {
  const Hysteresis model(linear_model());  // L_0 = (0 V, 1.5 um)
  HysteresisState state = model.virgin(4.0);
  const Prediction drive = model.inverse(state, 0.3);
  EXPECT_TRUE(drive.saturated);
  EXPECT_EQ(drive.value, 4.0);
  EXPECT_EQ(model.reachable(state).lo, state.output);
  const Interval reach = model.reachable(state, {0.0, 5.0});
  EXPECT_LE(reach.lo, reach.hi);
}

// The virgin curve does not pass through L_0, so that even a short loop between them is wide.
TEST(Hysteresis, TargetsTheLowerPointFromTheVirginCurve) {
  const Hysteresis model(linear_model(0.0));
  HysteresisState state = model.virgin(0.0);
  model.advance(state, 1e-5);
  EXPECT_NEAR(model.advance(state, 0.5e-5).value, 0.5 * (2e-6 + 1.5), rounding_um);
}

TEST(Hysteresis, FlagsAFallFromTheVirginCurveBelowTheLowerPoint) {
  const Hysteresis model(linear_model(0.05));
  HysteresisState state = model.virgin(0.0);
  EXPECT_TRUE(model.advance(state, 5.0).increasing);  // x = 1 um, L_0 = (0 V, 1.5 um)
  EXPECT_FALSE(model.forward(state, 4.0).increasing);
  EXPECT_FALSE(model.advance(state, 3.0).increasing);
  EXPECT_TRUE(model.advance(state, 0.0).increasing);
  EXPECT_TRUE(model.advance(state, 5.0).increasing);
  EXPECT_TRUE(model.advance(state, 3.0).increasing);
}

TEST(Hysteresis, StaysContinuousAndIncreasingWithAFullMemory) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.virgin(0.0, 6);
  for (const double v : nested_swings(model.input_range(), 20)) model.advance(state, v);
  EXPECT_EQ(state.depth(), 6u);
  EXPECT_GT(state.merged, 0u);
  const auto sweep = [&](double to) {
    const double way = to > state.input ? 1.0 : -1.0;
    while (way * (to - state.input) > 0.0) {
      const double before = state.output;
      const double v = state.input + way * 0.01;
      const double predicted = model.forward(state, v).value;
      EXPECT_EQ(model.advance(state, v).value, predicted);
      EXPECT_GT(way * (state.output - before), 0.0) << "at " << v;
      EXPECT_LT(way * (state.output - before), 0.01) << "at " << v;  // slopes are below 0.6 um/V
    }
  };
  sweep(52.0);
  sweep(48.0);
  sweep(70.0);
  sweep(20.0);
  sweep(99.0);
  EXPECT_LT(state.depth(), 6u);
}

TEST(Hysteresis, CopiesOfAStateKeepItsCapacity) {
  const Hysteresis model(piezo_model());
  const HysteresisState small = model.virgin(0.0, 4);
  HysteresisState copy = small;
  EXPECT_EQ(copy.branches.capacity(), 4u);
  for (const double v : nested_swings(model.input_range(), 20)) model.advance(copy, v);
  EXPECT_EQ(copy.depth(), 4u);
  EXPECT_EQ(small.depth(), 1u);
}

TEST(Hysteresis, RefusesAnInvalidInitialInputOrCapacity) {
  const Hysteresis model(piezo_model());
  EXPECT_THROW(model.virgin(-1.0), std::invalid_argument);
  EXPECT_THROW(model.virgin(101.0), std::invalid_argument);
  EXPECT_THROW(model.virgin(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_THROW(model.virgin(0.0, 3), std::invalid_argument);
  EXPECT_EQ(model.virgin(100.0).direction(), Direction::descending);
}

// Here the printed quotient is a quotient of infinities: the inner loop leaves its turning point and jumps to
// the outer curve.
TEST(Hysteresis, StaysExactIfThePrintedQuotientOverflows) {
  HysteresisParameters parameters = piezo_model();
  const std::vector<double> ascending = parameters.ascending.coefficients();
  std::vector<double> descending = ascending;
  const double gap = 1e-6;  // so narrow that this large k is still valid
  descending[0] += gap / 2;
  descending[1] -= gap / 2;
  parameters.descending = ReferenceCurve(Basis::chebyshev, descending, parameters.ascending.domain());
  parameters.k_ascending = parameters.k_descending = 1000.0;  // 1e5 per span
  const Hysteresis model(parameters);
  HysteresisState state = model.at_lower_threshold();
  model.advance(state, 60.0);
  model.advance(state, 40.0);
  const double falling = state.output;
  EXPECT_NEAR(falling, parameters.descending.value(40.0), 1e-13);
  EXPECT_NEAR(model.forward(state, 40.1).value, parameters.ascending.value(40.1), 1e-13);
  const double d = 1e-3;  // one decay length
  EXPECT_NEAR(
      model.forward(state, 40.0 + d).value,
      parameters.ascending.value(40.0 + d) + (falling - parameters.ascending.value(40.0)) * std::exp(-1.0),
      1e-13);
}

}  // namespace
}  // namespace hystcan::model::hysteresis_test
