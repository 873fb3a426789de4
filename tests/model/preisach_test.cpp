#include "model/preisach.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "model/hysteresis_operator.h"
#include "tests/model/models.h"
#include "tests/support/refusal.h"
#include "tests/support/relays.h"

namespace hystcan::model::preisach_test {
namespace {

static_assert(HysteresisOperator<Preisach>);

PreisachParameters random_grid(double gain) {
  const auto levels = static_cast<std::size_t>(*rc::gen::inRange(1, 12));
  PreisachParameters p{"V", "um", {-20.0, 60.0}, -3.0, gain, {}};
  for (std::size_t n = 0; n < levels * (levels + 1) / 2; ++n)
    p.weights.push_back(*rc::gen::inRange(0, 4) == 0 ? 0.0 : *number(0.01, 1.0));
  p.weights[0] += 0.1;
  return p;
}

TEST(Preisach, AgreesWithItsRelaysAtTheLevels) {
  EXPECT_TRUE(rc::check("for any walk from level to level", [] {
    const PreisachParameters p = random_grid(*rc::gen::element(0.0, 0.02));
    const Preisach model(p);
    support::Relays relays(p);
    HysteresisState state = model.virgin(p.input_range.lo);
    for (int i = 0; i < 60; ++i) {
      const double v =
          relays.level(static_cast<std::size_t>(*rc::gen::inRange(0, static_cast<int>(relays.levels()) + 1)));
      RC_ASSERT(std::abs(model.advance(state, v).value - relays.advance(v)) <=
                1e-12 * model.output_range().span());
    }
  }));
}

TEST(Preisach, SpreadsTheWeightOfACellEvenly) {
  // There is one cell, a triangle: a rise to the fraction t of the range switches t^2 of its weight.
  const Preisach model({"V", "um", {0.0, 1.0}, 0.0, 0.0, {1.0}});
  HysteresisState state = model.virgin(0.0);
  EXPECT_NEAR(model.advance(state, 0.5).value, 0.25, 1e-15);
  EXPECT_NEAR(model.advance(state, 0.8).value, 0.64, 1e-15);
  EXPECT_NEAR(model.advance(state, 0.5).value, 0.64 - 0.09, 1e-15);
  EXPECT_NEAR(model.advance(state, 0.7).value, 0.55 + 0.04, 1e-15);
  EXPECT_NEAR(model.advance(state, 0.8).value, 0.64, 1e-15);
}

TEST(Preisach, IsContinuousAndHasTheSlopeOfItsValues) {
  EXPECT_TRUE(rc::check("small steps across cells and turning points", [] {
    const EverettLaw law(random_grid(0.01));
    const Interval range = law.input_range();
    const double start = range.lo + range.span() * *number(0.05, 0.95);
    const double slope_scale = 100.0 / range.span();  // for 12 x 12 weights of up to 1
    for (const Direction way : {Direction::ascending, Direction::descending}) {
      const Branch branch{start, 0.0, 0.0, 0.0, true};
      const double end = way == Direction::ascending ? range.hi : range.lo;
      for (double t = 0.0; t < 1.0; t += 1.0 / 64.0) {
        const double v = start + t * (end - start), step = 1e-6 * (end - start);
        const Jet here = law.jet(branch, way, v), there = law.jet(branch, way, v + step);
        const double mean = (here.slope + there.slope) / 2.0;  // exact within a cell
        const bool kink = std::abs(there.slope - here.slope) > 1e-3 * slope_scale;
        RC_ASSERT(std::abs(there.value - here.value) <= std::abs(step) * slope_scale);
        RC_ASSERT(kink || std::abs(there.value - here.value - mean * step) <= 1e-9 * std::abs(step) + 1e-13);
      }
    }
  }));
}

TEST(Preisach, HasCongruentLoopsBetweenTheSameInputs) {
  const Preisach model({"V", "um", {0.0, 1.0}, 0.0, 0.1, {0.3, 0.1, 0.5, 0.2, 0.2, 0.4}});
  HysteresisState from_above = model.at_upper_threshold(), from_below = model.at_lower_threshold();
  const auto height = [&](HysteresisState& state) {
    const double top = model.advance(state, 0.7).value;
    return top - model.advance(state, 0.3).value;
  };
  model.advance(from_above, 0.3);
  EXPECT_NEAR(height(from_above), height(from_below), 1e-15);
}

TEST(Preisach, RoundTripIsExact) {
  EXPECT_TRUE(rc::check("inverse, then forward, within 1e-12 of span", [] {
    const Preisach model(random_grid(0.01));
    const auto walk = random_walk(model.input_range(), 10);
    HysteresisState state = model.virgin(walk[0]);
    for (const double v : walk) model.advance(state, v);
    for (int i = 0; i < 30; ++i) {
      const double x = model.output_range().lo + model.output_range().span() * *number(0.0, 1.0);
      const Prediction drive = model.inverse(state, x);
      RC_ASSERT(std::abs(model.advance(state, drive.value).value - x) <= 1e-12 * model.output_range().span());
    }
  }));
}

TEST(Preisach, RefusesAnInvalidGridOfWeights) {
  const auto refusal = [](const PreisachParameters& p) -> std::string {
    return support::refusal_of<std::invalid_argument>([&] { Preisach{p}; });
  };
  const PreisachParameters good{"V", "um", {0.0, 1.0}, 0.0, 0.0, {1.0, 0.5, 0.5}};
  EXPECT_EQ(refusal(good), "accepted");
  PreisachParameters bad = good;
  bad.weights.pop_back();
  EXPECT_NE(refusal(bad).find("2 weights, expected N (N + 1) / 2"), std::string::npos);
  bad = good;
  bad.weights[1] = -0.1;
  EXPECT_NE(refusal(bad).find("weight 1 is -0.1"), std::string::npos);
  bad = good;
  bad.gain = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(bad).find("gain is"), std::string::npos);
  bad = good;
  bad.input_range = {1.0, 0.0};
  EXPECT_NE(refusal(bad).find("expected finite lo < hi"), std::string::npos);
  bad = good;
  bad.weights = {0.0};
  EXPECT_NE(refusal(bad).find("expected an increasing output"), std::string::npos);
}

}  // namespace
}  // namespace hystcan::model::preisach_test
