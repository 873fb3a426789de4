// The whole Plant, not its parts, compared with the closed forms of mechanics.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "tests/twin/stage.h"

namespace hystcan::twin::closed_form_test {
namespace {

using std::chrono::milliseconds;

constexpr double two_pi = 2.0 * std::numbers::pi;

/// Response of a mode to a unit step, from rest.
double step_response(const model::SecondOrder::Config& mode, double time_s) {
  const double zeta = mode.damping_ratio, omega = two_pi * mode.natural_frequency_Hz;
  const double root = std::sqrt(1.0 - zeta * zeta), phase = omega * root * time_s;
  return 1.0 - std::exp(-zeta * omega * time_s) * (std::cos(phase) + zeta / root * std::sin(phase));
}

/// Response of amplifier and mode to a unit step of the target, by partial fractions of
///   a omega^2 / (s (s + a) (s^2 + 2 zeta omega s + omega^2))
double chain_response(const Plant::Config& config, double time_s) {
  const double zeta = config.mode.damping_ratio, omega = two_pi * config.mode.natural_frequency_Hz;
  const double a = two_pi * config.amplifier.bandwidth_Hz;
  const std::complex<double> p{-zeta * omega, omega * std::sqrt(1.0 - zeta * zeta)};
  const std::complex<double> of_pole = omega * omega * a / (p * (p + a) * (p - std::conj(p)));
  const double of_lag = -omega * omega / (a * a - 2.0 * zeta * omega * a + omega * omega);
  return 1.0 + of_lag * std::exp(-a * time_s) + 2.0 * std::real(of_pole * std::exp(p * time_s));
}

/// Largest distance of the position from `expected(t)` um, read every 37 us for `length_s`.
template <class Expected>
double largest_error_um(Plant& plant, double from_s, double length_s, Expected expected) {
  double largest = 0.0;
  for (int i = 1; i * 37e-6 <= length_s; ++i) {
    plant.advance_to(at_s(from_s + i * 37e-6));
    largest = std::max(largest, std::abs(plant.position_um() - expected(i * 37e-6)));
  }
  return largest;
}

// A load that is added at rest makes the mode oscillate freely about its new position. Frequency, decay and
// phase are checked over 50 periods. They are exact at any time between grid points, except for the rounding
// of 2000 steps.
TEST(FreeOscillation, FollowsItsClosedForm) {
  Plant plant(linear_stage(), can::Time{});
  plant.disturb({.load_um = 1.5});
  EXPECT_LT(
      largest_error_um(plant, 0.0, 0.1, [](double t) { return 1.5 * step_response(linear_stage().mode, t); }),
      1e-11);
}

TEST(FreeOscillation, IsTheSumOfTwoModesWeightedByTheirShares) {
  Plant::Config config = linear_stage();
  config.second_mode = SecondMode{{.natural_frequency_Hz = 1170.0, .damping_ratio = 0.01}, 0.2};
  Plant plant(config, can::Time{});
  plant.disturb({.load_um = 1.5});
  EXPECT_LT(largest_error_um(plant, 0.0, 0.1,
                             [&](double t) {
                               return 1.5 * (0.8 * step_response(config.mode, t) +
                                             0.2 * step_response(config.second_mode->mode, t));
                             }),
            1e-11);
}

TEST(FreeOscillation, ContinuesAtTheShiftedResonanceOfBothModes) {
  Plant::Config config = linear_stage();
  config.second_mode = SecondMode{{.natural_frequency_Hz = 1170.0, .damping_ratio = 0.01}, 0.2};
  Plant plant(config, can::Time{});
  plant.disturb({.resonance = 1.25});
  plant.disturb({.load_um = 1.0, .resonance = 0.8});
  model::SecondOrder::Config first = config.mode, second = config.second_mode->mode;
  first.natural_frequency_Hz *= 0.8;
  second.natural_frequency_Hz *= 0.8;
  EXPECT_LT(largest_error_um(
                plant, 0.0, 0.1,
                [&](double t) { return 0.8 * step_response(first, t) + 0.2 * step_response(second, t); }),
            1e-11);
}

// The drive is taken as linear within a sub-step, so the error is of second order in the sub-step. For a step
// of 15 um it is at most 0.081 um with the sub-step of 50 us.
TEST(StepResponse, FollowsItsClosedFormToSecondOrderInTheSubstep) {
  const auto error_um = [](int substep_us) {
    Plant::Config config = linear_stage();
    config.substep = std::chrono::microseconds(substep_us);
    Plant plant(config, can::Time{});
    plant.set_target(50.0);
    return largest_error_um(plant, 0.0, 0.05, [&](double t) { return 15.0 * chain_response(config, t); });
  };
  EXPECT_LT(error_um(50), 0.09);
  EXPECT_NEAR(error_um(50) / error_um(25), 4.0, 0.4);
  EXPECT_NEAR(error_um(25) / error_um(12), 25.0 * 25.0 / (12.0 * 12.0), 0.5);
}

TEST(LoadStep, RingsAboutTheDisplacementAndStaysThere) {
  Plant plant(piezo_stage(), can::Time{});
  plant.set_target(40.0);
  plant.advance_to(can::Time{} + milliseconds(500));
  const double before_um = plant.position_um();
  plant.disturb({.load_um = -2.0});
  EXPECT_EQ(plant.position_um(), before_um) << "a mass does not jump";
  // The first overshoot is e^{-pi zeta / sqrt(1 - zeta^2)}, after half a period.
  plant.advance_to(at_s(0.5 + 0.5 / (500.0 * std::sqrt(1.0 - 0.05 * 0.05))));
  const double overshoot = std::exp(-std::numbers::pi * 0.05 / std::sqrt(1.0 - 0.05 * 0.05));
  EXPECT_NEAR(plant.position_um() - before_um, -2.0 * (1.0 + overshoot), 1e-6);
  plant.advance_to(can::Time{} + milliseconds(1500));
  EXPECT_NEAR(plant.position_um() - before_um, -2.0, 1e-9);
}

TEST(LimitedOutput, StaysAtItsLimitUntilTheNextTarget) {
  Plant plant(piezo_stage(), can::Time{});
  plant.set_target(40.0);
  plant.advance_to(at_s(0.1));
  plant.disturb({.most_drive = 30.0});
  plant.advance_to(at_s(0.2));
  EXPECT_NEAR(plant.drive(), 30.0, 1e-9);
  plant.move_target(60.0, milliseconds(1));
  plant.advance_to(at_s(0.3));
  EXPECT_NEAR(plant.drive(), 30.0, 1e-9);
  plant.disturb({});
  plant.set_target(60.0);
  plant.advance_to(at_s(0.4));
  EXPECT_NEAR(plant.drive(), 60.0, 1e-9);
}

TEST(GainDisturbance, ScalesTheTravelFromTheStart) {
  Plant plant(piezo_stage(), can::Time{});
  plant.disturb({.gain = 0.9});
  plant.advance_to(can::Time{} + milliseconds(500));
  EXPECT_NEAR(plant.position_um(), 0.0, 1e-12) << "at the start there is no travel";
  plant.set_target(50.0);
  plant.advance_to(can::Time{} + milliseconds(1000));
  EXPECT_NEAR(plant.position_um(), 0.9 * support::piezo_model().ascending.value(50.0), 1e-9);
}

TEST(Disturbance, IsRefusedIfItIsNotPhysical) {
  Plant plant(piezo_stage(), can::Time{});
  EXPECT_THROW(plant.disturb({.resonance = 0.0}), std::invalid_argument);
  EXPECT_THROW(plant.disturb({.load_um = std::nan("")}), std::invalid_argument);
  EXPECT_THROW(plant.disturb({.gain = INFINITY}), std::invalid_argument);
  EXPECT_THROW(plant.disturb({.most_drive = -1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::twin::closed_form_test
