// How well the loop tracks: the shipped piezo stage against a twin that differs by 3 % in the curves and 20 %
// in k.
//
//   bench_tracking    prints the budget row (80 % stroke triangle, 10 Hz, 1 kHz cycle), then triangle and
//                     sine at 1 to 50 Hz for cycles of 1 and 4 kHz, in five columns each
//
// At each rate the gains are those of the rule (identification/dynamics/pi_rule.h) for the twin's mode, and
// the command delay is a cycle. An axis with the standard frames does not fit 1 Mbit/s at 4 kHz, which the
// program prints. The bit rate of the simulated bus follows the cycle rate, so that each frame takes the same
// part of a cycle.
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "config/schema/bus_plan.h"
#include "config/schema/config.h"
#include "controller/analysis/loop_design.h"
#include "rehearsal/rehearsal.h"

namespace {

using namespace hystcan;
using controller::Structure;
using Row = std::array<double, controller::all_structures.size()>;

constexpr double low_um = 3.0, high_um = 27.0;  // 80 % of the stroke
constexpr double settle_s = 0.1;

/// Axis x alone, with this cycle rate.
config::Config at_rate(config::Config config, double rate_Hz) {
  config.axes.resize(1);
  const double shipped_Hz = config.controller.rate_Hz;
  config.controller.rate_Hz = rate_Hz;
  config.axes[0].control.delays.command_delay = std::chrono::nanoseconds(std::llround(1e9 / rate_Hz));
  unsigned& every = config.axes[0].twin.status_every;
  every = static_cast<unsigned>(std::lround(every * rate_Hz / shipped_Hz));
  return config;
}

controller::LoopConfig loop_of(const config::Config& config) {
  const controller::AxisConfig& control = config.axes[0].control;
  return controller::loop_config_of(control.law, control.delays, 1.0 / config.controller.rate_Hz);
}

controller::Pi::Config gains_by_rule(const config::Config& config) {
  return controller::largest_gains(loop_of(config), controller::around(config.axes[0].control.delays, 0.0),
                                   controller::SensitivityRule{});
}

/// The RMS error in % of stroke for all_structures; NaN where the axis faulted.
Row track(const config::Config& config, const controller::Pi::Config& pi, const controller::Shape& shape) {
  rehearsal::Setup setup{.controller = controller_config(config),
                         .twin = twin_config(config),
                         .database = config.database,
                         .bitrate_bit_per_s = static_cast<std::uint32_t>(
                             config.bus.bitrate_bit_per_s * std::max(1.0, config.controller.rate_Hz / 1e3))};
  setup.controller.axes[0].axis.law.pi = pi;
  setup.controller.axes[0].axis.setpoint = {{.shape = shape, .transition_s = 0.2}};
  Row row;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const auto outcome = rehearsal::run_once(with_structure(setup, controller::all_structures[i]), settle_s,
                                             [](const auto&) {});
    const controller::AxisOutcome& axis = outcome.axes[0];
    row[i] = axis.fault.cause == controller::Cause::none
                 ? 100.0 * axis.statistics.total().rms_um() / axis.stroke_um
                 : std::nan("");
  }
  return row;
}

template <class Shape>
controller::Shape of_frequency(double frequency_Hz) {
  return Shape{.low_um = low_um,
               .high_um = high_um,
               .frequency_Hz = frequency_Hz,
               .cycles = std::max(3.0, frequency_Hz)};
}

void print_heading(const char* first) {
  std::printf("%-16s", first);
  for (const Structure structure : controller::all_structures)
    std::printf(" %11s", std::string(to_string(structure)).c_str());
  std::printf("   pi / inverse+pi   average+pi / inverse+pi\n");
}

void print(const std::string& name, const Row& row) {
  std::printf("%-16s", name.c_str());
  for (const double percent : row) std::printf(" %11.3f", percent);
  std::printf(" %17.1f %25.1f\n", row[2] / row[4], row[3] / row[4]);
}

void print_loop(const config::Config& config, const controller::Pi::Config& pi) {
  const twin::Plant::Config& plant = config.axes[0].twin.plant;
  const controller::Delays& delays = config.axes[0].control.delays;
  const auto margins = controller::margins_of(controller::LinearLoop(loop_of(config)), pi);
  std::printf(
      "sample rate %g Hz, command delay %g ms, preview %.3f ms, resonance %g Hz, damping %g, stroke 24 of 30 "
      "um; kp %g, ki %g/s: phase margin %.0f deg, gain margin %.1f dB\n",
      config.controller.rate_Hz, 1e-6 * static_cast<double>(delays.command_delay.count()),
      1e3 * delays.preview_s(1.0 / config.controller.rate_Hz), plant.mode.natural_frequency_Hz,
      plant.mode.damping_ratio, pi.kp, pi.ki_per_s, margins.phase_margin_deg,
      20.0 * std::log10(margins.gain_margin));
}

const char* verdict(bool met) { return met ? "met" : "missed"; }

void print_budget(const char* gains, const Row& row) {
  print(gains, row);
  std::printf(
      "  RMS %.3f %%, budget 0.25: %s; pi / inverse+pi %.1f, budget 50: %s; average+pi / inverse+pi "
      "%.1f, budget 12: %s\n",
      row[4], verdict(row[4] <= 0.25), row[2] / row[4], verdict(row[2] / row[4] >= 50.0), row[3] / row[4],
      verdict(row[3] / row[4] >= 12.0));
}

void print_table(const config::Config& config) {
  const controller::Pi::Config pi = gains_by_rule(config);
  std::printf("\n");
  print_loop(config, pi);
  const config::BusPlan plan = config::plan_bus(config);
  std::printf("one axis at 1 Mbit/s: load at most %.0f %%, commands %s\n", 100.0 * plan.load,
              plan.commands_in_time() ? "in time" : "not in time: the simulated bus is faster");
  print_heading("RMS error [%]");
  for (const double frequency_Hz : {1.0, 5.0, 10.0, 20.0, 50.0})
    print("triangle " + std::to_string(std::lround(frequency_Hz)) + " Hz",
          track(config, pi, of_frequency<controller::Triangle>(frequency_Hz)));
  for (const double frequency_Hz : {1.0, 5.0, 10.0, 20.0, 50.0})
    print("sine " + std::to_string(std::lround(frequency_Hz)) + " Hz",
          track(config, pi, of_frequency<controller::Sine>(frequency_Hz)));
}

}  // namespace

int main() {
  const config::Config shipped = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  const config::Config slow = at_rate(shipped, 1000.0);
  const controller::Pi::Config gains = slow.axes[0].control.law.pi;
  const auto triangle = of_frequency<controller::Triangle>(10.0);
  std::printf("80 %% stroke triangle, 10 Hz; the gains as shipped, then by the rule\n");
  print_loop(slow, gains);
  print_heading("RMS error [%]");
  print_budget("as shipped", track(slow, gains, triangle));
  print_budget("by the rule", track(slow, gains_by_rule(slow), triangle));
  print_table(slow);
  print_table(at_rate(shipped, 4000.0));
}
