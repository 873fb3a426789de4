// The sampled plant, compared with the twin's physics in fine steps.
#include "controller/analysis/linear_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace hystcan::controller::held_plant_test {
namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;
constexpr double cycle_s = 1e-3;

Delays delays_of(double delay_us) {
  return {.command_delay = std::chrono::nanoseconds(std::llround(1e3 * delay_us)),
          .amplifier_bandwidth_Hz = 700.0,
          .resonance_Hz = 230.0,
          .damping_ratio = 0.1};
}

/// Integrates amplifier, mode and sensor in small steps of Heun's method; returns the samples of a sine of
/// setpoints after `cycles`.
double sampled_after(const Delays& delays, double theta, int cycles) {
  constexpr int fine = 2000;
  const double dt_s = cycle_s / fine, omega = two_pi * delays.resonance_Hz, zeta = delays.damping_ratio;
  const double amplifier = two_pi * delays.amplifier_bandwidth_Hz,
               sensor = two_pi * delays.sensor_bandwidth_Hz;
  const double late_s = std::chrono::duration<double>(delays.command_delay + delays.sensor_delay).count();
  const auto setpoint = [&](double t_s) {
    const double n = std::floor(t_s / cycle_s + 1e-9), part = t_s / cycle_s - n;
    const double now = std::cos(theta * n), before = std::cos(theta * (n - 1.0));
    return delays.interpolated ? before + (now - before) * part : now;
  };
  double v = 0.0, x = 0.0, rate = 0.0, y = 0.0;
  for (int i = 0; i < cycles * fine; ++i) {
    const double u = setpoint((i + 0.5) * dt_s - late_s);  // the setpoint does not jump within a step
    const double v_mid = v + 0.5 * dt_s * amplifier * (u - v);
    const double x_mid = x + 0.5 * dt_s * rate;
    const double rate_mid = rate + 0.5 * dt_s * (omega * omega * (v - x) - 2.0 * zeta * omega * rate);
    const double y_mid = y + 0.5 * dt_s * sensor * (x - y);
    v += dt_s * amplifier * (u - v_mid);
    x += dt_s * rate_mid;
    rate += dt_s * (omega * omega * (v_mid - x_mid) - 2.0 * zeta * omega * rate_mid);
    y += dt_s * sensor * (x_mid - y_mid);
  }
  return delays.sensor_bandwidth_Hz > 0.0 ? y : x;
}

void expect_response(const Delays& delays) {
  constexpr int settled = 120;  // e^(-zeta omega t) = 3e-8
  for (const double theta : {0.3, 1.4, 2.9}) {
    const auto expected = response_of(held_plant(delays, cycle_s), theta) * std::polar(1.0, theta * settled);
    EXPECT_NEAR(sampled_after(delays, theta, settled), expected.real(), 5e-5) << theta;
  }
}

TEST(HeldPlant, AgreesWithTheIntegratedChain) {
  for (const double delay_us : {0.0, 300.0, 1000.0, 2710.0}) expect_response(delays_of(delay_us));
}

TEST(HeldPlant, AgreesForAnInterpolatingAmplifier) {
  for (const double delay_us : {0.0, 300.0, 1000.0}) {
    Delays delays = delays_of(delay_us);
    delays.interpolated = true;
    expect_response(delays);
  }
}

TEST(HeldPlant, AgreesForASensorWithDelayAndBandwidth) {
  Delays delays = delays_of(1000.0);
  delays.sensor_delay = std::chrono::microseconds(170);
  delays.sensor_bandwidth_Hz = 400.0;
  expect_response(delays);
}

TEST(HeldPlant, HasUnitGainAtRest) {
  for (const bool interpolated : {false, true}) {
    Delays delays = delays_of(300.0);
    delays.interpolated = interpolated;
    EXPECT_NEAR(std::abs(response_of(held_plant(delays, cycle_s), 0.0) - 1.0), 0.0, 1e-12);
  }
}

// Equal bandwidths of amplifier and sensor, and critical damping, are double poles.
TEST(HeldPlant, IsContinuousAtDoublePoles) {
  Delays meeting = delays_of(300.0), near = meeting;
  meeting.damping_ratio = 1.0;
  near.damping_ratio = 1.001;
  meeting.sensor_bandwidth_Hz = 700.0;
  near.sensor_bandwidth_Hz = 701.0;
  for (const double theta : {0.3, 1.4, 2.9})
    EXPECT_NEAR(std::abs(response_of(held_plant(meeting, cycle_s), theta) -
                         response_of(held_plant(near, cycle_s), theta)),
                0.0, 2e-3);
}

TEST(HeldPlant, RefusesInvalidParameters) {
  const auto refused = [](auto change) {
    Delays delays = delays_of(300.0);
    change(delays);
    EXPECT_THROW(held_plant(delays, cycle_s), std::invalid_argument);
  };
  refused([](Delays& d) { d.resonance_Hz = 0.0; });
  refused([](Delays& d) { d.damping_ratio = -0.1; });
  refused([](Delays& d) { d.amplifier_bandwidth_Hz = std::nan(""); });
  EXPECT_THROW(held_plant(delays_of(0.0), 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::controller::held_plant_test
