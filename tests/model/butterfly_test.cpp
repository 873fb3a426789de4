#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "model/any_model.h"
#include "model/hysteresis.h"
#include "tests/model/models.h"
#include "tests/model/oracle.h"
#include "tests/support/refusal.h"

namespace hystcan::model::butterfly_test {
namespace {

/// size ((s - valley)^2 + steeper s^4) as a Chebyshev series, s from -1 to 1 over the levels of the curves.
std::vector<double> coefficients(double size, double valley, double steeper = 0.0) {
  return {size * (0.5 + valley * valley + 0.375 * steeper), -2.0 * size * valley,
          size * (0.5 + 0.5 * steeper), 0.0, size * 0.125 * steeper};
}

HysteresisParameters with_map(HysteresisParameters p, const std::vector<double>& map) {
  p.output_map.emplace(map, Interval{p.ascending.value(p.input_range().lo), p.upper_point().level});
  return p;
}

/// A random model with a valley anywhere except at the upper end.
HysteresisParameters draw() {
  const double valley = *number(-1.2, 0.8);
  return with_map(RandomModel::draw(),
                  coefficients(*rc::gen::element(1e-3, 1.0, 50.0), valley, *number(0.0, 0.3)));
}

/// m varies from -1 to 1, without hysteresis at both ends; at zero input it is 0.3 or -0.3.
HysteresisParameters magnetisation() {
  const Interval range{-100.0, 100.0};
  return {.input_unit = "V",
          .output_unit = "um",
          .ascending = {Basis::power, {-0.3, 0.01, 3e-5}, range},
          .descending = {Basis::power, {0.3, 0.01, -3e-5}, range},
          .k_ascending = 0.005,
          .k_descending = 0.005};
}

double span_of(const Hysteresis& model) { return model.output_range().span(); }

TEST(Butterfly, IsTheMapOfTheBranches) {
  EXPECT_TRUE(rc::check("forward and advance equal g(the naive recursion)", [] {
    const Hysteresis model(draw());
    const OutputMap& map = *model.parameters().output_map;
    const auto walk = random_walk(model.input_range(), 40);
    HysteresisState state = model.virgin(walk[0]);
    Oracle oracle(model.parameters(), Oracle::Start::virgin, walk[0]);
    for (const double v : walk) {
      const double expected = map.value(static_cast<double>(oracle.advance(v)));
      RC_ASSERT(model.forward(state, v).value == model.advance(state, v).value);
      RC_ASSERT(std::abs(state.output - expected) <= 1e-11 * span_of(model));
    }
  }));
}

TEST(Butterfly, InverseGivesTheInputBeyondTheValley) {
  EXPECT_TRUE(rc::check("forward(inverse(x)) = x, beyond the valley, for every x within reach", [] {
    const Hysteresis model(draw());
    const double valley = model.parameters().output_map->valley();
    HysteresisState state = model.virgin(model.input_range().lo);
    for (const double v : random_walk(model.input_range(), 20)) model.advance(state, v);
    for (int i = 0; i < 10; ++i) {
      const Interval reach = model.reachable(state);
      const double x = reach.lo + reach.span() * *number(0.0, 1.0);
      const Prediction found = model.inverse(state, x);
      RC_ASSERT(!found.saturated || x == reach.lo || x == reach.hi);
      RC_ASSERT(std::abs(model.forward(state, found.value).value - x) <= 1e-12 * span_of(model));
      model.advance(state, found.value);
      RC_ASSERT(state.level >= valley - 1e-6 * model.parameters().output_map->inner().span());
    }
  }));
}

TEST(Butterfly, SaturatesAtTheValley) {
  const Hysteresis model(with_map(magnetisation(), coefficients(30.0, 0.0)));
  HysteresisState state = model.at_upper_threshold();
  EXPECT_NEAR(state.output, 30.0, 1e-12);
  const Prediction lowest = model.inverse(state, -1.0);
  EXPECT_TRUE(lowest.saturated);
  EXPECT_NEAR(model.forward(state, lowest.value).value, 0.0, 1e-12);
  EXPECT_LT(lowest.value, 0.0) << "the coercive input on the way down";
  EXPECT_FALSE(model.inverse(state, 0.1).saturated);
  EXPECT_TRUE(model.inverse(state, 31.0).saturated);
  EXPECT_NEAR(model.output_range().lo, 0.0, 1e-12);
}

TEST(Butterfly, HasItsValleyOnEitherSideOfZeroInput) {
  const Hysteresis model(with_map(magnetisation(), coefficients(30.0, 0.0)));
  const auto lowest = [&](double from, double to) {
    HysteresisState state = model.at_lower_threshold();
    if (from > 0.0) state = model.at_upper_threshold();
    double least = std::numeric_limits<double>::infinity(), at = 0.0;
    for (int i = 0; i <= 1000; ++i) {
      const double v = from + (to - from) * i / 1000.0;
      if (model.advance(state, v).value < least) {
        least = state.output;
        at = v;
      }
    }
    return at;
  };
  EXPECT_NEAR(lowest(-100.0, 100.0), 27.7, 0.2);
  EXPECT_NEAR(lowest(100.0, -100.0), -27.7, 0.2);
}

TEST(Butterfly, IsTheFoldWithoutCoercivity) {
  HysteresisParameters p = magnetisation();
  p.ascending = p.descending = {Basis::power, {0.0, 0.01}, p.input_range()};
  const Hysteresis butterfly(with_map(p, coefficients(30.0, 0.0)));
  const ReferenceCurve square(Basis::power, {0.0, 0.0, 30.0 / 1e4}, {0.0, 100.0});
  const Hysteresis fold({.input_unit = "V",
                         .output_unit = "um",
                         .ascending = square,
                         .descending = square,
                         .symmetry = Symmetry::even});
  HysteresisState a = butterfly.virgin(0.0), b = fold.virgin(0.0);
  for (const double v : long_walk({-100.0, 100.0}, 200, 5))
    ASSERT_NEAR(butterfly.advance(a, v).value, fold.advance(b, v).value, 1e-12);
}

TEST(Butterfly, RestoresItsMemoryToTheBit) {
  const Hysteresis model(with_map(magnetisation(), coefficients(30.0, 0.1)));
  HysteresisState state = model.at_upper_threshold();
  TurningPoints points{.origin = Origin::upper_threshold, .inputs = {}, .levels = {}, .level = {}};
  for (const double v : {-50.0, 60.0, -20.0}) {
    model.advance(state, v);
    points.inputs.push_back(v);
    points.levels.push_back(state.level);
  }
  model.advance(state, 10.0);
  points.input = 10.0;
  points.level = state.level;
  const HysteresisState restored = model.remembering(points);
  EXPECT_EQ(restored.output, state.output);
  for (const double v : {-10.0, 30.0, 70.0, -90.0})
    EXPECT_EQ(model.forward(restored, v).value, model.forward(state, v).value);
}

TEST(Butterfly, HasAMemoryOfItsOwnModel) {
  const Hysteresis model(magnetisation()), butterfly(with_map(magnetisation(), coefficients(30.0, 0.0))),
      other(with_map(magnetisation(), coefficients(30.0, 0.1)));
  EXPECT_NE(model.fingerprint(), butterfly.fingerprint());
  EXPECT_NE(other.fingerprint(), butterfly.fingerprint());
}

TEST(Butterfly, ConvertsFromNanometresToMicrometres) {
  HysteresisParameters p = with_map(magnetisation(), coefficients(30e3, 0.0));
  p.output_unit = "nm";
  const AnyModel converted = model_of(in_um(p));
  EXPECT_NEAR(std::get<Hysteresis>(converted).output_range().hi, 30.0, 1e-12);
}

TEST(Butterfly, IgnoresNumbersThatAreNotFinite) {
  const Hysteresis model(with_map(magnetisation(), coefficients(30.0, 0.0)));
  HysteresisState state = model.at_upper_threshold();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(model.inverse(state, nan).finite);
  EXPECT_FALSE(model.forward(state, nan).finite);
  EXPECT_FALSE(model.advance(state, nan).finite);
  EXPECT_NEAR(state.output, 30.0, 1e-12);
}

TEST(OutputMap, InverseIsExactToRounding) {
  EXPECT_TRUE(rc::check("value(inverse(x)) = x", [] {
    const double size = *rc::gen::element(1e-6, 1.0, 1e3);
    const OutputMap map(coefficients(size, *number(-2.0, 0.9), *number(0.0, 1.0)), {-3.0, 2.0});
    const Interval range = map.beyond_valley(map.inner());
    for (int i = 0; i < 20; ++i) {
      const double x = range.lo + range.span() * *number(0.0, 1.0);
      const Prediction found = map.inverse(x);
      RC_ASSERT(found.value >= map.valley());
      RC_ASSERT(std::abs(map.value(found.value) - x) <= 4e-15 * size * 10.0);
    }
  }));
}

TEST(OutputMap, RefusesACrestOrAFallAtItsEnd) {
  const auto refusal = [](const std::vector<double>& map) -> std::string {
    return support::refusal_of<std::invalid_argument>([&] { OutputMap made(map, {-1.0, 1.0}); });
  };
  EXPECT_NE(refusal({0.0, 0.0, -1.0}).find("after an increase"), std::string::npos);
  EXPECT_NE(refusal({0.0, -1.0}).find("still falls at its upper end"), std::string::npos);
  EXPECT_NE(refusal({0.0, 0.0, 0.0, 0.0, 1.0}).find("after an increase"), std::string::npos);
  EXPECT_EQ(refusal({0.0, 1.0}), "accepted") << "it only rises";
}

TEST(Butterfly, RefusesAMapThatDoesNotFitItsCurves) {
  HysteresisParameters p = magnetisation();
  p.output_map.emplace(std::vector<double>{0.0, 0.0, 1.0}, Interval{-1.0, 2.0});
  EXPECT_THROW(Hysteresis{p}, std::invalid_argument);
  p.output_map.emplace(std::vector<double>{0.0, 0.0, 1.0}, Interval{-0.5, 1.0});
  EXPECT_THROW(Hysteresis{p}, std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::model::butterfly_test
