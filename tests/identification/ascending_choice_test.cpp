// The ascending curve without samples.
#include "identification/ascending_choice.h"

#include <gtest/gtest.h>

#include <vector>

#include "model/hysteresis.h"
#include "tests/model/models.h"

namespace hystcan::identification::ascending_choice_test {
namespace {

using model::Hysteresis;
using model::HysteresisParameters;

/// A model whose ascending curve begins below the loops that leave the lower threshold.
HysteresisParameters far_below(double k_span) {
  HysteresisParameters p = model::piezo_model();
  const model::Interval range = p.input_range();
  p.k_ascending = p.k_descending = k_span / range.span();
  std::vector<double> a = p.ascending.coefficients();
  a.resize(std::max<std::size_t>(a.size(), 2));
  a[0] -= 2.0;  // 4 um lower at the lower threshold, unchanged at the upper one
  a[1] += 2.0;
  p.ascending = p.ascending.with(a);
  return p;
}

std::vector<double> outputs(const Hysteresis& model, const std::vector<double>& inputs) {
  model::HysteresisState state = model.at_lower_threshold();
  std::vector<double> outputs;
  outputs.reserve(inputs.size());
  for (const double v : inputs) outputs.push_back(model.advance(state, v).value);
  return outputs;
}

TEST(AscendingChoice, BeginsAtTheLowerPointAndKeepsTheLoops) {
  for (const double k_span : {0.0, 0.7, 1.5, -0.5}) {
    const HysteresisParameters given = far_below(k_span);
    EXPECT_FALSE(begins_at_lower_point(given));
    const HysteresisParameters chosen = with_ascending_from_lower(given, 1e-6);
    EXPECT_TRUE(begins_at_lower_point(chosen)) << k_span;
    const model::Interval range = given.input_range();
    std::vector<double> inputs;
    for (const double share : {0.0, 0.3, 0.1, 0.8, 0.2, 0.6, 0.4, 1.0, 0.5, 0.9, 0.0, 0.7})
      inputs.push_back(range.lo + share * range.span());
    const std::vector<double> before = outputs(Hysteresis(given), inputs),
                              after = outputs(Hysteresis(chosen), inputs);
    for (std::size_t i = 0; i < inputs.size(); ++i)
      EXPECT_NEAR(after[i], before[i], 4e-6) << "k " << k_span << ", input " << inputs[i];
  }
}

TEST(AscendingChoice, KeepsAModelIfNoCurveIsClose) {
  const HysteresisParameters given = far_below(2.0);
  const HysteresisParameters kept = with_ascending_from_lower(given, 0.0);
  EXPECT_EQ(kept.ascending.coefficients(), given.ascending.coefficients());
}

}  // namespace
}  // namespace hystcan::identification::ascending_choice_test
