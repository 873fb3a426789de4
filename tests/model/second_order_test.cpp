#include "model/second_order.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace hystcan::model::second_order_test {
namespace {

using State = SecondOrder::State;

constexpr double frequency_Hz = 450.0;
constexpr double omega = 2.0 * std::numbers::pi * frequency_Hz;

// Free motion from (x0, v0) in every damping regime.
State free_motion(double zeta, double x0, double v0, double t) {
  const double decay = std::exp(-zeta * omega * t);
  if (zeta < 1.0) {
    const double w = omega * std::sqrt(1.0 - zeta * zeta);
    const double b = (v0 + zeta * omega * x0) / w;
    const double x = decay * (x0 * std::cos(w * t) + b * std::sin(w * t));
    return {x, -zeta * omega * x + decay * w * (b * std::cos(w * t) - x0 * std::sin(w * t))};
  }
  if (zeta == 1.0) {
    const double b = v0 + omega * x0;
    return {decay * (x0 + b * t), decay * (b - omega * (x0 + b * t))};
  }
  const double root = omega * std::sqrt(zeta * zeta - 1.0);
  const double fast = -zeta * omega - root, slow = -zeta * omega + root;
  const double a = (v0 - fast * x0) / (slow - fast), b = x0 - a;
  return {a * std::exp(slow * t) + b * std::exp(fast * t),
          a * slow * std::exp(slow * t) + b * fast * std::exp(fast * t)};
}

class SecondOrderRegimes : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Damping, SecondOrderRegimes,
                         testing::Values(0.0, 0.02, 0.7, 0.999999, 1.0, 1.000001, 3.0));

TEST_P(SecondOrderRegimes, FollowsTheClosedFormOfFreeMotion) {
  const double zeta = GetParam(), dt = 1.3e-4;
  const SecondOrder step({frequency_Hz, zeta}, dt);
  State state{1.0, -0.3 * omega};
  for (int n = 1; n <= 200; ++n) {
    state = step(state, 0.0, 0.0);
    const State exact = free_motion(zeta, 1.0, -0.3 * omega, n * dt);
    // The closed form loses digits near zeta = 1.
    const double tolerance = std::abs(zeta - 1.0) < 1e-3 && zeta != 1.0 ? 1e-10 : 2e-13;
    EXPECT_NEAR(state.position, exact.position, tolerance);
    EXPECT_NEAR(state.velocity, exact.velocity, tolerance * omega);
  }
}

TEST_P(SecondOrderRegimes, FollowsTheClosedFormOfAStepResponse) {
  const double zeta = GetParam(), dt = 1e-3;
  const SecondOrder step({frequency_Hz, zeta}, dt);
  State state;
  for (int n = 1; n <= 50; ++n) {
    state = step(state, 2.0, 2.0);
    const State exact = free_motion(zeta, -2.0, 0.0, n * dt);
    EXPECT_NEAR(state.position, 2.0 + exact.position, 1e-9);
    EXPECT_NEAR(state.velocity, exact.velocity, 1e-9 * omega);
  }
}

TEST_P(SecondOrderRegimes, FollowsTheClosedFormOfARampResponse) {
  const double zeta = GetParam(), dt = 3e-4, rate = 500.0;
  const SecondOrder step({frequency_Hz, zeta}, dt);
  const double lag = 2.0 * zeta / omega * rate;  // x -> u - lag
  State state;
  for (int n = 1; n <= 100; ++n) {
    state = step(state, rate * (n - 1) * dt, rate * n * dt);
    const State exact = free_motion(zeta, lag, -rate, n * dt);
    EXPECT_NEAR(state.position, rate * n * dt - lag + exact.position, 1e-9);
    EXPECT_NEAR(state.velocity, rate + exact.velocity, 1e-9 * omega);
  }
}

TEST_P(SecondOrderRegimes, DoesNotDependOnTheSizeOfTheSteps) {
  const double zeta = GetParam();
  const SecondOrder big({frequency_Hz, zeta}, 1e-3), small({frequency_Hz, zeta}, 1e-3 / 64);
  State one{0.2, 30.0}, many = one;
  for (int n = 0; n < 20; ++n) {
    const double before = std::sin(0.7 * n), after = std::sin(0.7 * (n + 1));
    one = big(one, before, after);
    for (int i = 0; i < 64; ++i)
      many = small(many, before + (after - before) * i / 64, before + (after - before) * (i + 1) / 64);
    EXPECT_NEAR(one.position, many.position, 1e-12);
    EXPECT_NEAR(one.velocity, many.velocity, 1e-12 * omega);
  }
}

TEST_P(SecondOrderRegimes, StaysExactlyAtRestAtAHeldInput) {
  for (const double dt : {1e-12, 1e-6, 1e-3, 1.0}) {
    const SecondOrder step({frequency_Hz, GetParam()}, dt);
    State state{12.345678, 0.0};
    for (int n = 0; n < 100; ++n) state = step(state, 12.345678, 12.345678);
    EXPECT_EQ(state.position, 12.345678);
    EXPECT_EQ(state.velocity, 0.0);
  }
}

// omega dt = 3e-8: the input's share of a step is 4e-16. A closed form would lose it in the rounding of its
// terms.
TEST(SecondOrder, IsExactForTinySteps) {
  const double dt = 1e-11;
  const SecondOrder step({frequency_Hz, 0.0}, dt);
  const State after = step({0.0, 0.0}, 1.0, 1.0);
  EXPECT_NEAR(after.position / (0.5 * omega * omega * dt * dt), 1.0, 1e-14);
  EXPECT_NEAR(after.velocity / (omega * omega * dt), 1.0, 1e-14);
  const State ramped = step({0.0, 0.0}, 0.0, 1.0);
  EXPECT_NEAR(ramped.position / (omega * omega * dt * dt / 6.0), 1.0, 1e-14);
  EXPECT_NEAR(ramped.velocity / (0.5 * omega * omega * dt), 1.0, 1e-14);
}

TEST(SecondOrder, KeepsItsAmplitudeWithoutDamping) {
  const SecondOrder step({frequency_Hz, 0.0}, 1e-4);
  State state{1.0, 0.0};
  for (int n = 0; n < 100000; ++n) state = step(state, 0.0, 0.0);
  EXPECT_NEAR(std::hypot(state.position, state.velocity / omega), 1.0, 1e-10);
}

// 113 bits of significand, as long double has on arm64, would give ...dp-15.
TEST(SecondOrder, HasTheSameBitsOnEveryProcessor) {
  const State after = SecondOrder({frequency_Hz, 1.42}, 1e-3)({0.0, 1.0}, 0.0, 0.0);
  EXPECT_EQ(after.position, 0x1.c9b19d7db75aep-15);
  EXPECT_EQ(after.velocity, -0x1.ffea8b519e733p-5);
}

TEST(SecondOrder, RefusesInvalidParameters) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto make = [](double f, double zeta, double dt) { SecondOrder({f, zeta}, dt); };
  EXPECT_THROW(make(0.0, 0.1, 1e-3), std::invalid_argument);
  EXPECT_THROW(make(-1.0, 0.1, 1e-3), std::invalid_argument);
  EXPECT_THROW(make(nan, 0.1, 1e-3), std::invalid_argument);
  EXPECT_THROW(make(100.0, -0.1, 1e-3), std::invalid_argument);
  EXPECT_THROW(make(100.0, nan, 1e-3), std::invalid_argument);
  EXPECT_THROW(make(100.0, 0.1, 0.0), std::invalid_argument);
  EXPECT_THROW(make(100.0, 0.1, nan), std::invalid_argument);
  EXPECT_THROW(make(1e12, 0.1, 1e3), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::model::second_order_test
