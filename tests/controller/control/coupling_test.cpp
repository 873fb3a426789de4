// Two axes of a stage; each also moves the other one. To first order:  y_i = own_i + c y_j
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "controller/control/axis.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::coupling_test {
namespace {

constexpr double cycle_s = 1e-3;
constexpr double crosstalk = 0.03;

AxisConfig axis_of(bool fed_forward, std::size_t other) {
  AxisConfig config = support::piezo_axis();
  config.delays.command_delay = {};
  config.delays.amplifier_bandwidth_Hz = 1e9;  // the actuators below respond at the next sample
  config.delays.resonance_Hz = 1e9;
  config.following_error.error_um = 20.0;
  config.law.pi = {.kp = 0.0, .ki_per_s = 20.0};
  config.setpoint = {{.shape = Sine{.low_um = 5.0, .high_um = 25.0, .frequency_Hz = 5.0, .cycles = 100.0}}};
  if (other == 0)  // the resting axis
    config.setpoint = {{.shape = Hold{.level_um = 12.0, .duration_s = 10.0}}};
  if (fed_forward) config.couplings = {{.from = "other", .um_per_um = crosstalk, .index = other}};
  return config;
}

/// RMS error of the resting axis while the other axis sweeps.
double error_of_the_standing_axis_um(bool fed_forward) {
  std::array<AxisConfig, 2> configs{axis_of(false, 1), axis_of(fed_forward, 0)};
  std::array<std::unique_ptr<Axis>, 2> axes;
  const model::Hysteresis actuator(support::piezo_model());
  std::array<model::HysteresisState, 2> memories{actuator.virgin(0.0), actuator.virgin(0.0)};
  std::array<AxisCommand, 2> commands{};
  for (std::size_t i = 0; i < 2; ++i) {
    axes[i] = std::make_unique<Axis>(configs[i]);
    axes[i]->start(false);
  }
  double squares = 0.0;
  int counted = 0;
  for (int cycle = 1; cycle <= 3000; ++cycle) {
    const double time_s = cycle_s * cycle;
    const bool begin = axes[0]->state() >= AxisState::ready && axes[1]->state() >= AxisState::ready;
    for (std::size_t i = 0; i < 2; ++i) {
      AxisInput input{.time_s = time_s,
                      .dt_s = cycle_s,
                      .cycle_s = cycle_s,
                      .position_um = memories[i].output + crosstalk * memories[1 - i].output,
                      .tracking_since_s = begin ? std::optional(time_s) : std::nullopt,
                      .health = {.sensor_alive = true,
                                 .sensor_operational = true,
                                 .amplifier_alive = true,
                                 .amplifier_operational = true,
                                 .amplifier_ready = true,
                                 .amplifier_enabled = commands[i].enable,
                                 .amplifier_output = memories[i].input}};
      for (const model::Coupling& coupling : configs[i].couplings)
        input.coupled_um += coupling.um_per_um * axes[coupling.index]->expected_um(
                                                     time_s + axes[i]->closed_loop()->preview_s(cycle_s));
      commands[i] = axes[i]->step(input);
    }
    for (std::size_t i = 0; i < 2; ++i) actuator.advance(memories[i], commands[i].drive);
    if (cycle < 1500) continue;
    EXPECT_EQ(axes[1]->state(), AxisState::tracking) << to_string(axes[1]->fault().cause);
    const double error_um = axes[1]->report().reference_um - axes[1]->report().position_um;
    squares += error_um * error_um;
    ++counted;
  }
  return std::sqrt(squares / counted);
}

// The sweep of 20 um moves the resting axis by 0.6 um. The hysteresis of the resting axis is inverted
// exactly, so the error with feed-forward is of second order in the crosstalk: a hundredth of it is allowed.
TEST(Coupling, FeedForwardCompensatesTheMotionOfTheOtherAxis) {
  const double without_um = error_of_the_standing_axis_um(false);
  const double with_um = error_of_the_standing_axis_um(true);
  EXPECT_GT(without_um, 0.05);
  EXPECT_LT(with_um, 0.1 * without_um) << "without: " << without_um;
}

}  // namespace
}  // namespace hystcan::controller::coupling_test
