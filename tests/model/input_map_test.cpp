// A model with an input map h and curves linear in h equals the model without a map for the input h(v).
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "model/hysteresis.h"
#include "model/validity.h"

namespace hystcan::model::input_map_test {
namespace {

const std::vector<double> knots{-20.0, -3.0, 0.0, 2.0, 9.0, 40.0};
const CubicSpline map(knots, {-5.0, -4.0, -3.5, 0.0, 6.0, 7.0, 8.0, 11.0});
const Interval range{-20.0, 40.0};
const Interval inner{map.value(range.lo), map.value(range.hi)};

ReferenceCurve linear_in_map(double offset, double gain) {
  std::vector<double> coefficients = map.coefficients();
  for (double& c : coefficients) c = offset + gain * c;
  return {CubicSpline(knots, coefficients), range};
}

constexpr double k_ascending = 0.12, k_descending = 0.2;

Hysteresis mapped() {
  const double gap = 0.4;
  return Hysteresis({.input_unit = "A/m",
                     .output_unit = "mT",
                     .ascending = linear_in_map(3.0, 2.0),
                     .descending = linear_in_map(3.0 + gap * inner.hi, 2.0 - gap),
                     .k_ascending = k_ascending,
                     .k_descending = k_descending,
                     .input_map = map});
}

Hysteresis plain() {
  const double gap = 0.4;
  return Hysteresis({.input_unit = "A/m",
                     .output_unit = "mT",
                     .ascending = {Basis::power, {3.0, 2.0}, inner},
                     .descending = {Basis::power, {3.0 + gap * inner.hi, 2.0 - gap}, inner},
                     .k_ascending = k_ascending,
                     .k_descending = k_descending});
}

const double span = plain().output_range().span();

std::vector<double> inputs_of(const std::vector<int>& parts) {
  std::vector<double> inputs;
  for (const int part : parts) inputs.push_back(range.lo + range.span() * std::abs(part % 1001) / 1000.0);
  return inputs;
}

RC_GTEST_PROP(InputMap, GivesTheModelOfTheMappedInput, (const std::vector<int>& parts)) {
  const Hysteresis model = mapped(), inner_model = plain();
  auto state = model.virgin(range.lo, 512);
  auto inner_state = inner_model.virgin(inner.lo, 512);
  for (const double v : inputs_of(parts)) {
    const Prediction step = model.advance(state, v),
                     inner_step = inner_model.advance(inner_state, map.value(v));
    RC_ASSERT(std::abs(step.value - inner_step.value) <= 1e-11 * span);
    RC_ASSERT(step.increasing == inner_step.increasing);
    RC_ASSERT(state.depth() == inner_state.depth());
  }
}

RC_GTEST_PROP(InputMap, InverseIsExact, (const std::vector<int>& parts)) {
  const Hysteresis model = mapped();
  auto state = model.at_lower_threshold(512);
  for (const double v : inputs_of(parts)) {
    const double wanted = model.forward(state, v).value;
    const Prediction found = model.inverse(state, wanted);
    RC_ASSERT(!found.saturated);
    RC_ASSERT(std::abs(model.forward(state, found.value).value - wanted) <= 1e-13 * span);
    model.advance(state, v);
  }
}

TEST(InputMap, KeepsTinyLoopsClosed) {
  const Hysteresis model = mapped();
  for (const double v : {-19.0, -2.0, 1.0, 30.0})
    for (const double size : {1e-1, 1e-5, 1e-9}) {
      auto state = model.at_lower_threshold();
      model.advance(state, v);
      const double before = state.output;
      model.advance(state, v - size);
      model.advance(state, v - 0.5 * size);
      EXPECT_NEAR(model.advance(state, v).value, before, 1e-13 * span) << v << " " << size;
      EXPECT_EQ(state.depth(), 1U);
    }
}

TEST(InputMap, IsRefusedIfItDoesNotIncrease) {
  HysteresisParameters parameters = mapped().parameters();
  std::vector<double> flat = map.coefficients();
  flat[3] = flat[2];
  parameters.input_map.emplace(knots, flat);
  EXPECT_THROW(Hysteresis{parameters}, std::invalid_argument);
}

TEST(InputMap, LimitsKAsTheModelOfTheMappedInput) {
  const auto limits = allowed_k(mapped().parameters(), Direction::ascending);
  const auto inner_limits = allowed_k(plain().parameters(), Direction::ascending);
  ASSERT_TRUE(limits && inner_limits);
  EXPECT_NEAR(limits->hi / inner_limits->hi, 1.0, 0.02);  // the grids differ
}

TEST(InputMap, ChangesTheFingerprint) {
  HysteresisParameters parameters = mapped().parameters();
  parameters.input_map.reset();
  EXPECT_NE(Hysteresis::beyond_limit(parameters).fingerprint(), mapped().fingerprint());
}

}  // namespace
}  // namespace hystcan::model::input_map_test
