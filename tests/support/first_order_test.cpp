#include "tests/support/first_order.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace hystcan::support::first_order_test {
namespace {

using State = FirstOrder::State;

constexpr double bandwidth_Hz = 450.0;
constexpr double omega = 2.0 * std::numbers::pi * bandwidth_Hz;

constexpr double dt_of(double tau) { return tau / omega; }

TEST(FirstOrder, FollowsTheClosedFormOfADecay) {
  const double dt = 1.3e-4;
  const FirstOrder::Step step({bandwidth_Hz}, dt);
  State state{1.0};
  for (int n = 1; n <= 100; ++n) {
    state = step(state, 0.0, 0.0);
    EXPECT_NEAR(state.value, std::exp(-omega * n * dt), 1e-15);  // a few roundings of numbers below 1
  }
}

TEST(FirstOrder, FollowsTheClosedFormOfAStepResponse) {
  const double dt = 4e-5;
  const FirstOrder::Step step({bandwidth_Hz}, dt);
  State state;
  for (int n = 1; n <= 100; ++n) {
    state = step(state, 2.0, 2.0);
    EXPECT_NEAR(state.value, -2.0 * std::expm1(-omega * n * dt), 4e-15);  // roundings of numbers up to 2
  }
}

TEST(FirstOrder, FollowsTheClosedFormOfARampResponse) {
  const double dt = 3e-4, rate = 500.0;
  const FirstOrder::Step step({bandwidth_Hz}, dt);
  State state;
  for (int n = 1; n <= 100; ++n) {
    state = step(state, rate * (n - 1) * dt, rate * n * dt);
    const double t = n * dt;
    EXPECT_NEAR(state.value, rate * (t + std::expm1(-omega * t) / omega), 1e-14);  // numbers up to 15
  }
}

TEST(FirstOrder, DoesNotDependOnTheSizeOfTheSteps) {
  const FirstOrder::Step big({bandwidth_Hz}, 1e-3), small({bandwidth_Hz}, 1e-3 / 64);
  State one{0.2}, many = one;
  for (int n = 0; n < 20; ++n) {
    const double before = std::sin(0.7 * n), after = std::sin(0.7 * (n + 1));
    one = big(one, before, after);
    for (int i = 0; i < 64; ++i)
      many = small(many, before + (after - before) * i / 64, before + (after - before) * (i + 1) / 64);
    EXPECT_NEAR(one.value, many.value, 1e-14);  // 64 roundings of numbers below 1, most of them forgotten
  }
}

TEST(FirstOrder, StaysExactlyAtRestAtAHeldInput) {
  for (const double dt : {1e-16, 1e-6, 1e-3, 1.0, 1e6}) {
    const FirstOrder::Step step({bandwidth_Hz}, dt);
    State state{12.345678};
    for (int n = 0; n < 100; ++n) state = step(state, 12.345678, 12.345678);
    EXPECT_EQ(state.value, 12.345678);
  }
}

// tau = 1e-12: the shares of both inputs are tau / 2. A closed form would lose them in 1 - e^{-tau} - tau.
TEST(FirstOrder, IsExactForTinySteps) {
  const double tau = 1e-12;
  const FirstOrder::Step step({bandwidth_Hz}, dt_of(tau));
  EXPECT_NEAR(step({0.0}, 1.0, 1.0).value / tau, 1.0, 2e-12);  // 1 - tau / 2 + ...
  EXPECT_NEAR(step({0.0}, 1.0, 0.0).value / (tau / 2 - tau * tau / 3), 1.0, 1e-15);
  EXPECT_NEAR(step({0.0}, 0.0, 1.0).value / (tau / 2 - tau * tau / 6), 1.0, 1e-15);
}

TEST(FirstOrder, IsExactForHugeSteps) {
  const double tau = 1e6;
  const FirstOrder::Step step({bandwidth_Hz}, dt_of(tau));
  EXPECT_NEAR(step({1.0}, 0.0, 0.0).value, 0.0, 1e-15);
  EXPECT_NEAR(step({0.0}, 1.0, 0.0).value, 1.0 / tau, 1e-15);
  EXPECT_NEAR(step({0.0}, 0.0, 1.0).value, 1.0 - 1.0 / tau, 1e-15);
}

TEST(FirstOrder, IsExactForEverySizeOfTheStep) {
  for (int i = 0; i <= 180; ++i) {
    const double tau = std::pow(10.0, -12.0 + 0.1 * i);  // to 1e6
    const FirstOrder::Step step({bandwidth_Hz}, dt_of(tau));
    const long double t = tau, mean = -std::expm1(-t) / t;
    EXPECT_NEAR(step({0.0}, 1.0, 0.0).value, static_cast<double>(mean - std::exp(-t)), 1e-15) << tau;
    EXPECT_NEAR(step({0.0}, 0.0, 1.0).value, static_cast<double>(1 - mean), 1e-15) << tau;
    EXPECT_NEAR(step({1.0}, 0.0, 0.0).value, static_cast<double>(std::exp(-t)), 1e-15) << tau;
  }
}

TEST(FirstOrder, WeightsBothEndsOfATinyStepEqually) {
  const FirstOrder::Step step({bandwidth_Hz}, dt_of(1e-9));
  const double before = step({0.0}, 1.0, 0.0).value, after = step({0.0}, 0.0, 1.0).value;
  EXPECT_NEAR(before / after, 1.0, 1e-9);  // 1 - tau / 3 + ...
}

TEST(FirstOrder, RefusesAnInvalidBandwidthOrStep) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto make = [](double f, double dt) { FirstOrder::Step({f}, dt); };
  EXPECT_THROW(make(0.0, 1e-3), std::invalid_argument);
  EXPECT_THROW(make(-1.0, 1e-3), std::invalid_argument);
  EXPECT_THROW(make(nan, 1e-3), std::invalid_argument);
  EXPECT_THROW(make(infinity, 1e-3), std::invalid_argument);
  EXPECT_THROW(make(100.0, 0.0), std::invalid_argument);
  EXPECT_THROW(make(100.0, nan), std::invalid_argument);
}

TEST(FirstOrder, NamesTheParameterThatItRefuses) {
  try {
    const FirstOrder::Step step({-3.0}, 1e-3);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "bandwidth_Hz = -3, expected a positive number");
  }
}

}  // namespace
}  // namespace hystcan::support::first_order_test
