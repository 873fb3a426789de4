#include "model/dynamics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace hystcan::model::dynamics_test {
namespace {

constexpr double cycle_s = 1e-3;

TEST(DynamicOutput, FollowsTheClosedFormOfAStepAfterTheDelay) {
  const double f = 40.0, zeta = 0.2, delay_s = 2.3e-3;
  DynamicOutput output({{f, zeta}, delay_s}, cycle_s, 2.0);
  EXPECT_EQ(output.advance(2.0), 2.0);
  for (int n = 1; n < 100; ++n) {
    const double position = output.advance(3.0);  // the step is at row 1
    const double t = (n - 1) * cycle_s - delay_s;
    const double omega = 2.0 * std::numbers::pi * f, root = std::sqrt(1.0 - zeta * zeta);
    const double risen =
        t <= 0.0 ? 0.0
                 : 1.0 - std::exp(-zeta * omega * t) *
                             (std::cos(omega * root * t) + zeta / root * std::sin(omega * root * t));
    EXPECT_NEAR(position, 2.0 + risen, 1e-9) << "row " << n;
  }
}

TEST(DynamicOutput, IsConstantForAConstantInput) {
  DynamicOutput output({{100.0, 0.01}, 5e-4}, cycle_s, 17.3);
  for (int n = 0; n < 1000; ++n) EXPECT_NEAR(output.advance(17.3), 17.3, 1e-12);
}

TEST(DynamicOutput, RefusesInvalidParameters) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(DynamicOutput({{100.0, 0.1}, -1e-3}, cycle_s, 0.0), std::invalid_argument);
  EXPECT_THROW(DynamicOutput({{100.0, 0.1}, nan}, cycle_s, 0.0), std::invalid_argument);
  EXPECT_THROW(DynamicOutput({{0.0, 0.1}, 0.0}, cycle_s, 0.0), std::invalid_argument);
  EXPECT_THROW(DynamicOutput({{100.0, -0.1}, 0.0}, cycle_s, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::model::dynamics_test
