#include "model/creep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <ostream>
#include <stdexcept>
#include <string>

#include "tests/support/refusal.h"

namespace hystcan::model::creep_test {
namespace {

Creep::Operators two_thresholds() { return {{0.6, 2.0, 0.0}, {0.3, 0.5, 1.0}, {-0.1, 40.0, 4.0}}; }

// Output `t` seconds after a unit step of the input, from rest.
double crept(const Creep::Operators& config, double t) {
  Creep::State state = Creep::settled(config, 0.0);
  return Creep(config, t)(state, 1.0);
}

std::string refusal_of(const Creep::Operators& config, double dt_s) {
  return support::refusal_of<std::invalid_argument>([&] { const Creep step(config, dt_s); });
}

TEST(Creep, FollowsTheClosedFormUpToOneThresholdBelowTheInput) {
  const Creep::Operators config{{0.5, 3.0, 2.0}};
  const Creep step(config, 0.1);
  Creep::State state = Creep::settled(config, 0.0);
  for (int n = 1; n <= 200; ++n)
    EXPECT_NEAR(step(state, 10.0), 0.5 * -8.0 * std::expm1(-3.0 * n * 0.1), 1e-14);  // roundings of 8
  EXPECT_NEAR(state[0], 8.0, 1e-14);
}

TEST(Creep, FollowsTheClosedFormDownToOneThresholdAboveTheInput) {
  const Creep::Operators config{{0.5, 3.0, 2.0}};
  const Creep step(config, 0.1);
  Creep::State state = Creep::settled(config, 10.0);
  for (int n = 1; n <= 200; ++n)
    EXPECT_NEAR(step(state, 0.0), 0.5 * (2.0 + 8.0 * std::exp(-3.0 * n * 0.1)), 1e-14);  // roundings of 10
  EXPECT_NEAR(state[0], 2.0, 1e-14);
}

TEST(Creep, DoesNotMoveWhileTheInputStaysWithinItsThreshold) {
  const Creep::Operators config{{0.5, 3.0, 2.0}};
  const Creep step(config, 0.1);
  Creep::State state = Creep::settled(config, 10.0);
  for (const double input : {10.0, 11.9, 8.1, 12.0, 8.0}) EXPECT_EQ(step(state, input), 5.0);
}

TEST(Creep, IsTheWeightedSumOfItsOperators) {
  const Creep::Operators config = two_thresholds();
  Creep::State together = Creep::settled(config, 1.5);
  double sum = 0.0;
  for (const Creep::Operator& one : config) {
    const Creep::Operators alone{{one}};
    Creep::State state = Creep::settled(alone, 1.5);
    sum += Creep(alone, 0.3)(state, 7.0);
  }
  EXPECT_DOUBLE_EQ(Creep(config, 0.3)(together, 7.0), sum);
}

TEST(Creep, DoesNotDependOnTheSizeOfTheStepsWhileTheInputIsHeld) {
  const Creep::Operators config = two_thresholds();
  const Creep big(config, 0.64), small(config, 0.01);
  Creep::State one = Creep::settled(config, 0.0), many = one;
  for (const double input : {10.0, 3.0, 3.5, -8.0, -8.0, 20.0}) {
    const double at_once = big(one, input);
    for (int i = 0; i < 64; ++i) small(many, input);
    EXPECT_NEAR(small.output(many), at_once, 1e-13);  // 64 roundings of numbers below 20
  }
}

TEST(Creep, StaysExactlyAtRestAfterItHasSettled) {
  const Creep::Operators config = two_thresholds();
  Creep::State state = Creep::settled(config, 12.345678);
  const Creep step(config, 1e-3);
  const double at_rest = step.output(state);
  for (int n = 0; n < 100; ++n) EXPECT_EQ(step(state, 12.345678), at_rest);
  for (const double y : state) EXPECT_EQ(y, 12.345678);
}

TEST(Creep, HasTheWeightedInputAsItsOutputAtRest) {
  const Creep::Operators config = two_thresholds();
  EXPECT_DOUBLE_EQ(Creep(config, 1.0).output(Creep::settled(config, 5.0)), 0.8 * 5.0);
}

TEST(Creep, IsExactForTinySteps) {
  const Creep::Operators config{{1.0, 1e-3, 0.0}};
  EXPECT_NEAR(crept(config, 1e-12) / 1e-15, 1.0, 1e-15);
}

TEST(Creep, IgnoresAnInputThatIsNotFinite) {
  const Creep::Operators config = two_thresholds();
  const Creep step(config, 0.1);
  Creep::State state = Creep::settled(config, 0.0);
  const double before = step(state, 10.0);
  const Creep::State kept = state;
  EXPECT_EQ(step(state, std::numeric_limits<double>::quiet_NaN()), before);
  EXPECT_EQ(step(state, -std::numeric_limits<double>::infinity()), before);
  EXPECT_EQ(state, kept);
}

TEST(Creep, IsZeroWithoutOperators) {
  Creep::State state = Creep::settled({}, 3.0);
  EXPECT_EQ(Creep({}, 0.1)(state, 10.0), 0.0);
}

TEST(Creep, NamesTheOperatorThatItRefuses) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Creep::Operator good{1.0, 1.0, 0.0};
  EXPECT_EQ(refusal_of({{good, {1.0, 0.0, 0.0}}}, 1.0),
            "creep operator[1].rate_per_s = 0, expected a positive number");
  EXPECT_EQ(refusal_of({{1.0, nan, 0.0}}, 1.0),
            "creep operator[0].rate_per_s = nan, expected a positive number");
  EXPECT_EQ(refusal_of({{good, good, {1.0, 1.0, -2.5}}}, 1.0),
            "creep operator[2].threshold = -2.5, expected a number, zero or more");
  EXPECT_EQ(refusal_of({{nan, 1.0, 0.0}}, 1.0), "creep operator[0].weight = nan, expected a finite number");
  EXPECT_EQ(refusal_of({{good}}, 0.0), "dt_s = 0, expected a positive number");
  EXPECT_EQ(refusal_of({{good}}, nan), "dt_s = nan, expected a positive number");
}

struct Span {
  const char* name;
  double from_s, to_s;

  friend void PrintTo(const Span& span, std::ostream* out) { *out << span.name; }
};
class LogarithmicCreep : public testing::TestWithParam<Span> {};
INSTANTIATE_TEST_SUITE_P(Spans, LogarithmicCreep,
                         testing::Values(Span{"FourDecades", 0.1, 1e3}, Span{"Almost4Decades", 0.1, 700.0},
                                         Span{"SixDecades", 1.0, 1e6}, Span{"FactorOfTwo", 0.01, 0.02},
                                         Span{"APerMille", 1e-3, 1e-3 * 1.001}),
                         [](const auto& test) { return std::string(test.param.name); });

constexpr double gamma_per_decade = 0.015;

// The tolerance is 0.24 % of gamma, as stated in the header.
TEST_P(LogarithmicCreep, FollowsTheLogarithmOverItsSpan) {
  const auto [name, from, to] = GetParam();
  const Creep::Operators config = logarithmic_creep(gamma_per_decade, from, to);
  const double at_start = crept(config, from);
  for (int i = 0; i <= 500; ++i) {
    const double t = from * std::pow(to / from, i / 500.0);
    const double law = gamma_per_decade * std::log10(t / from);
    EXPECT_NEAR(crept(config, t) - at_start, law, 0.0024 * gamma_per_decade) << t;
  }
}

// The tolerance is 0.6 % of gamma, as stated in the header. The rise is measured over 0.02 decades, a 25th of
// the ripple's period.
TEST_P(LogarithmicCreep, CreepsGammaPerDecadeEverywhereInItsSpan) {
  const auto [name, from, to] = GetParam();
  const Creep::Operators config = logarithmic_creep(gamma_per_decade, from, to);
  for (int i = 0; i <= 500; ++i) {
    const double t = from * std::pow(to / from, i / 500.0);
    const double rise = crept(config, t * std::pow(10.0, 0.01)) - crept(config, t * std::pow(10.0, -0.01));
    EXPECT_NEAR(rise / 0.02, gamma_per_decade, 0.006 * gamma_per_decade) << t;
  }
}

TEST_P(LogarithmicCreep, HasReachedOneGammaAtTheBeginningOfItsSpan) {
  const auto [name, from, to] = GetParam();
  const double before = crept(logarithmic_creep(gamma_per_decade, from, to), from);
  EXPECT_NEAR(before / gamma_per_decade, 1.0, 0.005);  // the header states 1.00
}

TEST_P(LogarithmicCreep, IncreasesByTwoToTwoAndAHalfGammaAfterItsSpan) {
  const auto [name, from, to] = GetParam();
  const Creep::Operators config = logarithmic_creep(gamma_per_decade, from, to);
  const double rest = (crept(config, 1e6 * to) - crept(config, to)) / gamma_per_decade;
  EXPECT_GT(rest, 2.0 - 0.005);  // the error of the law at to_s
  EXPECT_LT(rest, 2.5 + 0.005);
}

TEST(LogarithmicCreep, HasTwoOperatorsPerDecade) {
  const Creep::Operators config = logarithmic_creep(0.02, 0.1, 1000.0);
  ASSERT_EQ(config.size(), 14u);  // two per decade over 4 + 2 decades, both ends, and one before
  EXPECT_DOUBLE_EQ(config.front().rate_per_s, std::sqrt(10.0) / 0.1);
  EXPECT_DOUBLE_EQ(config.back().rate_per_s, 1e-5);
  for (const Creep::Operator& one : config) {
    EXPECT_EQ(one.weight, 0.01);
    EXPECT_EQ(one.threshold, 0.0);
  }
}

TEST(LogarithmicCreep, RefusesAnInvalidSpanOrGamma) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(logarithmic_creep(nan, 0.1, 10.0), std::invalid_argument);
  EXPECT_THROW(logarithmic_creep(0.01, 0.0, 10.0), std::invalid_argument);
  EXPECT_THROW(logarithmic_creep(0.01, nan, 10.0), std::invalid_argument);
  EXPECT_THROW(logarithmic_creep(0.01, 10.0, 10.0), std::invalid_argument);
  EXPECT_THROW(logarithmic_creep(0.01, 10.0, nan), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::model::creep_test
