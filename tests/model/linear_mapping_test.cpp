#include "model/linear_mapping.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <stdexcept>

#include "model/hysteresis_operator.h"
#include "tests/model/models.h"

namespace hystcan::model::linear_mapping_test {
namespace {

static_assert(HysteresisOperator<LinearMapping>);

double mapped(const ReferenceCurve& curve, Point start, Point target, double v) {
  const double share =
      (curve.value(v) - curve.value(start.input)) / (curve.value(target.input) - curve.value(start.input));
  return start.level + (target.level - start.level) * share;
}

TEST(LinearMapping, JoinsStartAndTargetByTheReferenceCurveOfItsDirection) {
  const HysteresisParameters p = piezo_model();
  const LinearMapping model(p);
  HysteresisState state = model.at_lower_threshold();
  const Point lower{0.0, 0.8}, upper{100.0, 30.0};
  const Point high{70.0, mapped(p.ascending, lower, upper, 70.0)};
  EXPECT_NEAR(model.advance(state, 70.0).value, high.level, 1e-13);
  const Point low{30.0, mapped(p.descending, high, lower, 30.0)};
  EXPECT_NEAR(model.advance(state, 30.0).value, low.level, 1e-13);
  EXPECT_NEAR(model.advance(state, 50.0).value, mapped(p.ascending, low, high, 50.0), 1e-13);
  EXPECT_NEAR(model.advance(state, 70.0).value, high.level, 1e-13);
  EXPECT_NEAR(model.advance(state, 80.0).value, mapped(p.ascending, lower, upper, 80.0), 1e-13);
}

TEST(LinearMapping, FollowsTheReferenceCurvesBetweenTheThresholds) {
  const HysteresisParameters p = piezo_model();
  const LinearMapping model(p);
  HysteresisState state = model.virgin(0.0);
  for (const double v : {0.0, 40.0, 99.0}) EXPECT_EQ(model.forward(state, v).value, p.ascending.value(v));
  model.advance(state, 100.0);
  for (const double v : {60.0, 1.0}) EXPECT_NEAR(model.forward(state, v).value, p.descending.value(v), 1e-13);
}

TEST(LinearMapping, RoundTripIsExact) {
  EXPECT_TRUE(rc::check("inverse, then forward, within 1e-12 of span", [] {
    const LinearMapping model(RandomModel::draw());
    HysteresisState state = model.at_lower_threshold();
    for (const double v : random_walk(model.input_range(), 15)) model.advance(state, v);
    for (int i = 0; i < 30; ++i) {
      const double x = model.output_range().lo + model.output_range().span() * *number(0.0, 1.0);
      const Prediction drive = model.inverse(state, x);
      RC_ASSERT(!drive.saturated);
      RC_ASSERT(std::abs(model.advance(state, drive.value).value - x) <= 1e-12 * model.output_range().span());
    }
  }));
}

// The recursive model corrects this defect (paper, introduction): if the loop narrows faster than the
// reference curve rises, a mapped inner branch leaves the surrounding loop. A sufficiently large k prevents
// this.
TEST(LinearMapping, LeavesALoopThatTheRecursiveModelStaysIn) {
  // f_A = v, f_D = f_A + 0.1 (1 - v) + 0.15 v (1 - v)^2 on [0, 1]
  const Interval range{0.0, 1.0};
  const HysteresisParameters p{"V",
                               "um",
                               ReferenceCurve(Basis::power, {0.0, 1.0}, range),
                               ReferenceCurve(Basis::power, {0.1, 1.05, -0.3, 0.15}, range),
                               6.0,
                               6.0,
                               Symmetry::none};
  const auto narrowest_gap = [&](const auto& model) {
    HysteresisState state = model.at_upper_threshold();
    model.advance(state, 0.5);
    double gap = 1.0;
    for (double v = 0.51; v < 1.0; v += 0.01)
      gap = std::min(gap, p.descending.value(v) - model.forward(state, v).value);
    return gap;
  };
  EXPECT_GT(narrowest_gap(Hysteresis(p)), 0.0);
  EXPECT_LT(narrowest_gap(LinearMapping(p)), -1e-3);
}

TEST(LinearMapping, RefusesCurvesThatCross) {
  HysteresisParameters p = piezo_model();
  std::swap(p.ascending, p.descending);
  EXPECT_THROW(LinearMapping{p}, std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::model::linear_mapping_test
