#include "model/output_creep.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/hysteresis_operator.h"
#include "tests/model/models.h"
#include "tests/model/saved_text.h"
#include "tests/support/refusal.h"

namespace hystcan::model::output_creep_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr OutputCreep::Config piezo{.per_decade = 0.02};  // 10 ms to 3 s: six lags

TEST(OutputCreep, HasTwoLagsInEachDecade) {
  const OutputCreep creep(piezo);
  EXPECT_EQ(creep.lags(), 6u);
  EXPECT_EQ(creep.weight(), 0.01);
  EXPECT_DOUBLE_EQ(creep.at_once(), 0.94);
  EXPECT_EQ(OutputCreep({.per_decade = 0.02, .from_s = 0.5, .to_s = 0.5}).lags(), 1u);
}

TEST(OutputCreep, IsAbsentWithoutAConfig) {
  const OutputCreep creep;
  OutputCreep::State state = creep.settled(7.0);
  creep.advance(state, 3.0, 1.0);
  EXPECT_EQ(creep.output(state, 3.0), 3.0);
  EXPECT_EQ(creep.inverse(state, 3.0), 3.0);
}

OutputCreep::Config draw_config() {
  const double from_s = std::pow(10.0, *number(-4.0, 1.0));
  return {.per_decade = *number(-0.1, 0.1),
          .from_s = from_s,
          .to_s = from_s * std::pow(10.0, *number(0.0, 3.0))};  // 7 lags of 0.05: 0.65 are immediate
}

TEST(OutputCreep, InverseThenOutputIsTheIdentity) {
  EXPECT_TRUE(rc::check("for any lags, from any state", [] {
    const OutputCreep creep(draw_config());
    OutputCreep::State state = creep.settled(*number(-50.0, 50.0));
    creep.advance(state, *number(-50.0, 50.0), std::pow(10.0, *number(-5.0, 2.0)));
    const double x = *number(-50.0, 50.0);
    const double tolerance = 1e-12 * 50.0;  // relative to the size of the numbers
    RC_ASSERT(std::abs(creep.output(state, creep.inverse(state, x)) - x) <= tolerance);
    RC_ASSERT(std::abs(creep.inverse(state, creep.output(state, x)) - x) <= tolerance);
  }));
}

// y_i is the sum of the answers to all steps of h.
double superposition(const OutputCreep::Config& config, std::size_t lags, const std::vector<double>& time_s,
                     const std::vector<double>& h) {
  const std::size_t last = h.size() - 1;
  long double late = 0.0L;
  for (std::size_t i = 0; i < lags; ++i) {
    const long double tau_s = config.from_s * std::pow(10.0L, static_cast<long double>(i) / 2.0L);
    late += h[0];
    for (std::size_t k = 1; k < last; ++k)
      late -= (static_cast<long double>(h[k]) - h[k - 1]) *
              std::expm1(-(static_cast<long double>(time_s[last]) - time_s[k]) / tau_s);
  }
  const long double w = config.per_decade / 2.0L, n = static_cast<long double>(lags);
  return static_cast<double>((1.0L - n * w) * h[last] + w * late);
}

TEST(OutputCreep, IsTheSumOfTheAnswersToAllSteps) {
  EXPECT_TRUE(rc::check("a held course at uneven times", [] {
    const OutputCreep::Config config = draw_config();
    HeldCreep creep{OutputCreep(config)};
    std::vector<double> time_s{0.0}, h{*number(-50.0, 50.0)};
    creep.hold_until(0.0);
    creep.follow(h[0]);
    for (int n = 1; n < 30; ++n) {
      time_s.push_back(time_s.back() + std::pow(10.0, *number(-5.0, 1.0)));
      h.push_back(*number(-50.0, 50.0));
      creep.hold_until(time_s.back());
      const double oracle = superposition(config, creep.creep().lags(), time_s, h);
      RC_ASSERT(std::abs(creep.follow(h.back()) - oracle) <= 1e-12 * 50.0);
    }
  }));
}

TEST(OutputCreep, DoesNotDependOnTheSizeOfTheStepsWhileTheOutputIsHeld) {
  const OutputCreep creep(piezo);
  OutputCreep::State one = creep.settled(0.0), many = one;
  for (const double h : {10.0, 3.0, 3.5, -8.0, -8.0, 20.0}) {
    creep.advance(one, h, 0.64);
    for (int i = 0; i < 64; ++i) creep.advance(many, h, 0.01);
    EXPECT_NEAR(creep.output(many, h), creep.output(one, h), 1e-13);  // 64 roundings of numbers below 20
  }
}

// The lags form a comb in log t; a decade shifts it by two teeth. Only its ends are missing:
//
//   x(10 t) - x(t) = w h [2 - e^{-sqrt(10) t / from} - e^{-10 t / from} - (1 - e^{-sqrt(10) t / to}) - (1 -
//   e^{-t / to})]
//
// From t = from_s on, and until t = to_s / 100, the ends contribute up to 2.1 % each.
TEST(OutputCreep, IncreasesByPerDecadeInEachDecadeOfItsSpan) {
  const OutputCreep creep({.per_decade = 0.02, .from_s = 1e-3, .to_s = 10.0});
  const double h = 30.0;
  const auto after = [&](double t) {
    OutputCreep::State state = creep.settled(0.0);
    creep.advance(state, h, t);
    return creep.output(state, h);
  };
  for (int i = 0; i <= 200; ++i) {
    const double t = 1e-3 * std::pow(10.0, 2.0 * i / 200.0);
    EXPECT_NEAR(after(10.0 * t) - after(t), 0.02 * h, 0.022 * 0.02 * h) << t;
  }
}

TEST(OutputCreep, ReachesItsFinalValueAfterALongTime) {
  const OutputCreep creep(piezo);
  OutputCreep::State state = creep.settled(0.0);
  EXPECT_DOUBLE_EQ(creep.output(state, 30.0), 0.94 * 30.0);
  creep.advance(state, 30.0, 1000.0);
  EXPECT_DOUBLE_EQ(creep.output(state, 30.0), 30.0);
}

TEST(OutputCreep, StaysExactlyAtRestAfterItHasSettled) {
  const OutputCreep creep(piezo);
  OutputCreep::State state = creep.settled(12.345678);
  for (int n = 0; n < 100; ++n) creep.advance(state, 12.345678, 1e-3);
  for (const double y : state) EXPECT_EQ(y, 12.345678);
  EXPECT_DOUBLE_EQ(creep.output(state, 12.345678), 12.345678);
}

TEST(OutputCreep, IgnoresAnOutputThatIsNotFinite) {
  const OutputCreep creep(piezo);
  OutputCreep::State state = creep.settled(1.0);
  creep.advance(state, nan, 1.0);
  creep.advance(state, -infinity, 1.0);
  for (const double y : state) EXPECT_EQ(y, 1.0);
}

TEST(OutputCreep, HasTheAmplitudeOfASimulatedSine) {
  const OutputCreep creep({.per_decade = 0.05});
  for (const double frequency_Hz : {0.3, 2.0, 20.0}) {
    const double omega = 2.0 * std::numbers::pi * frequency_Hz;
    const int rows = 4000, periods = static_cast<int>(std::ceil(25.0 * frequency_Hz));  // 25 s: eight lags
    const double dt_s = 1.0 / (frequency_Hz * rows);
    OutputCreep::State state = creep.settled(0.0);
    std::complex<double> sum;
    for (int n = 0; n < rows * periods; ++n) {
      const double h = std::sin(omega * n * dt_s);
      if (n >= rows * (periods - 1)) sum += creep.output(state, h) * std::polar(1.0, -omega * n * dt_s);
      creep.advance(state, h, dt_s);
    }
    // A held drive is late by half a row, 8e-4 rad; the transient has decayed to 3e-4 of the weight.
    EXPECT_NEAR(2.0 * std::abs(sum) / rows, creep.amplitude_at(frequency_Hz), 1e-4) << frequency_Hz;
  }
  EXPECT_DOUBLE_EQ(creep.amplitude_at(0.0), 1.0);
  EXPECT_NEAR(creep.amplitude_at(1e6), creep.at_once(), 1e-9);
}

struct Refused {
  const char* name;
  OutputCreep::Config config;
  const char* message;

  friend void PrintTo(const Refused& refused, std::ostream* out) { *out << refused.name; }
};
class OutputCreepConfig : public testing::TestWithParam<Refused> {};

TEST_P(OutputCreepConfig, IsRefusedWithTheReason) {
  const std::string refusal =
      support::refusal_of<std::invalid_argument>([&] { const OutputCreep creep(GetParam().config); });
  EXPECT_EQ(refusal, GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Of, OutputCreepConfig,
    testing::Values(
        Refused{"NaN", {nan, 0.01, 3.0}, "creep per_decade = nan, expected a finite number"},
        Refused{"NoTime", {0.02, 0.0, 3.0}, "creep from_s = 0, expected a positive number"},
        Refused{"NaNFrom", {0.02, nan, 3.0}, "creep from_s = nan, expected a positive number"},
        Refused{
            "Backwards", {0.02, 1.0, 0.5}, "creep to_s = 0.5, expected a finite number, at least from_s = 1"},
        Refused{"Endless",
                {0.02, 1.0, infinity},
                "creep to_s = inf, expected a finite number, at least from_s = 1"},
        Refused{"TooManyLags",
                {1e-3, 1e-10, 1e6},
                "creep from_s = 1e-10 to to_s = 1e+06 makes 33 lags, expected at most 32"},
        Refused{"TooMuch",
                {0.5, 0.01, 1.0},
                "creep per_decade = 0.5 with 5 first-order lags leaves a share without lag of -0.25 in the "
                "output, expected at least 0.5: lower per_decade or to_s"}),
    [](const auto& test) { return test.param.name; });

// Times and wanted outputs. 0.2 to 0.8 of the range is within reach for any creep: with n w = 0.06 it
// requires 0.15 to 0.85 of the range of h.
struct Course {
  std::vector<double> time_s, x;

  static Course draw(const Hysteresis& model) {
    const Interval range = model.output_range();
    Course course;
    for (double t = 0.0; course.x.size() < 40; t += std::pow(10.0, *number(-4.0, 1.0))) {
      course.time_s.push_back(t);
      course.x.push_back(range.lo + range.span() * *number(0.2, 0.8));
    }
    return course;
  }
};

TEST(CreepBehindHysteresis, InverseThenForwardReturnsTheCourse) {
  EXPECT_TRUE(rc::check("a random course at uneven times", [] {
    const Hysteresis model(RandomModel::draw());
    const Course course = Course::draw(model);
    auto inverse = model.at_lower_threshold(), forward = inverse;
    HeldCreep wanted{OutputCreep(piezo)}, reached{OutputCreep(piezo)};
    for (std::size_t i = 0; i < course.x.size(); ++i) {
      wanted.hold_until(course.time_s[i]);
      const Prediction drive = model.inverse(inverse, wanted.inverse(course.x[i]));
      RC_ASSERT(!drive.saturated);
      model.advance(inverse, drive.value);
      wanted.follow(inverse.output);
      reached.hold_until(course.time_s[i]);
      model.advance(forward, inverse.input);
      const double x = reached.follow(forward.output);
      RC_ASSERT(std::abs(x - course.x[i]) <= 1e-12 * model.output_range().span());
    }
  }));
}

TEST(HeldCreep, BeginsSettledAtTheFirstRow) {
  HeldCreep creep{OutputCreep(piezo)};
  EXPECT_FALSE(creep.state());
  creep.hold_until(5.0);
  EXPECT_EQ(creep.inverse(17.0), 17.0);
  EXPECT_DOUBLE_EQ(creep.follow(17.0), 17.0);
  creep.hold_until(9.0);
  EXPECT_DOUBLE_EQ(creep.follow(17.0), 17.0);
}

TEST(HeldCreep, ContinuesFromACopyToTheBit) {
  HeldCreep whole{OutputCreep(piezo)};
  std::optional<HeldCreep> second;
  for (int n = 0; n < 100; ++n) {
    if (n == 50) second.emplace(OutputCreep(piezo), whole.state());
    const double time_s = 0.1 * n, h = 10.0 * std::sin(0.3 * n);
    whole.hold_until(time_s);
    const double x = whole.follow(h);
    if (!second) continue;
    second->hold_until(time_s);
    EXPECT_TRUE(same_bits(second->follow(h), x)) << n;
  }
}

TEST(HeldCreep, BeginsWithItsStateIfItHasNoTime) {
  const OutputCreep creep(piezo);
  OutputCreep::State late = creep.settled(0.0);
  creep.advance(late, 10.0, 0.1);
  HeldCreep held(creep, HeldCreep::State{.creep = late, .h = 10.0});
  held.hold_until(1000.0);
  EXPECT_EQ(held.follow(10.0), creep.output(late, 10.0));
}

}  // namespace
}  // namespace hystcan::model::output_creep_test
