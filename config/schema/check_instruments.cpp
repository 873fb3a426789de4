#include "config/schema/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/schema/bus_plan.h"

namespace hystcan::config {
namespace {

class InstrumentCheck : Checked {
 public:
  InstrumentCheck(const Checked& checked, std::size_t index)
      : Checked(checked), axis_(config.axes[index]), twin_(axis_.twin), amplifier_(twin_.plant.amplifier) {}

  void run() const {
    check_load();
    check_voltage();
    check_watchdog();
    check_interpolation();
    check_ripple();
    check_sensor();
  }

 private:
  void check_load() const {
    if (std::isfinite(amplifier_.current_limit_A) && amplifier_.load_uF == 0.0)
      fail(amplifier_.current_limit_A, "load_uF is 0, expected the capacitance that current_limit_A charges");
    if (std::isfinite(amplifier_.voltage_limit_V) && amplifier_.load_mH == 0.0)
      fail(amplifier_.voltage_limit_V,
           "load_mH is 0, expected the inductance of the coil, to which voltage_limit_V applies");
  }

  void check_voltage() const {
    if (!std::isfinite(amplifier_.voltage_limit_V)) return;
    const controller::Gate::Config& gate = axis_.control.gate;
    const double largest_A =
        std::max({std::abs(gate.drive_min), std::abs(gate.drive_max), std::abs(amplifier_.safe_drive)});
    const double needed_V = amplifier_.load_ohm * largest_A;
    if (amplifier_.voltage_limit_V < needed_V)
      fail(amplifier_.voltage_limit_V,
           "voltage_limit_V is {:g}, expected at least {:g}: {:g} A must flow through load_ohm",
           amplifier_.voltage_limit_V, needed_V, largest_A);
  }

  void check_watchdog() const {
    if (twin_.watchdog_action == node::WatchdogAction::ramp && !std::isfinite(amplifier_.ramp_per_s))
      fail(twin_.watchdog_action,
           "missing key {}, expected the speed of the ramp of watchdog_action \"ramp\"",
           key_of(axis_, amplifier_.ramp_per_s));
    if (twin_.watchdog_action == node::WatchdogAction::off && twin::Amplifier::discharge_s(amplifier_) == 0.0)
      fail(twin_.watchdog_action,
           "the load's time constant is 0, expected load_ohm with load_uF or load_mH: the output falls with "
           "this time constant if watchdog_action is \"off\"");
  }

  void check_interpolation() const {
    if (twin_.interpolate && twin_.apply == node::Apply::receipt)
      fail(twin_.interpolate,
           "interpolate is true with apply \"receipt\", expected apply = \"sync\": the ramp to a "
           "setpoint lasts from one SYNC to the next");
  }

  void check_ripple() const {
    const twin::DriveNoise::Config& noise = twin_.drive_noise;
    const double highest_Hz = 0.5 / can::seconds(twin_.plant.substep);
    if (noise.ripple > 0.0 && !(noise.ripple_Hz > 0.0 && noise.ripple_Hz <= highest_Hz))
      fail(noise.ripple_Hz, "ripple_Hz is {:g}, expected more than 0 and at most {:g}, 1 / (2 substep_us)",
           noise.ripple_Hz, highest_Hz);
  }

  void check_sensor() const {
    const twin::Sensor::Config& sensor = twin_.sensor;
    if (sensor.noise_density_um_per_rtHz > 0.0 && sensor.bandwidth_Hz == 0.0)
      fail(sensor.noise_density_um_per_rtHz,
           "bandwidth_Hz is 0, expected more than 0: without a low pass, the white noise has infinite power");
    if (!(sensor.range_min_um < sensor.range_max_um))
      fail(sensor.range_max_um, "range_max_um is {:g}, expected more than range_min_um, {:g}",
           sensor.range_max_um, sensor.range_min_um);
    if (sensor.nonlinearity_percent != 0.0 && !std::isfinite(sensor.range_max_um - sensor.range_min_um))
      fail(
          sensor.nonlinearity_percent,
          "range_min_um or range_max_um is missing, expected both: nonlinearity_percent refers to the range");
  }

  const AxisConfig& axis_;
  const twin::AxisConfig& twin_;
  const twin::Amplifier::Config& amplifier_;
};

/// Returns the worst-case time from a SYNC to the end of the axis's command in the same cycle.
can::Duration latest_command(const BusPlan& plan, const Config& config, const AxisConfig& axis) {
  const auto map = can::message_map_in<can::AmpCommand>(config.database, axis.wire);
  const std::string& name = can::find_message(config.database, *map).name;
  const auto found =
      std::ranges::find(plan.frames, name, [](const PlannedFrame& planned) { return planned.frame.name; });
  return found == plan.frames.end() ? plan.cycle : found->response.value_or(plan.cycle);
}

}  // namespace

void check_instruments(const Checked& checked, std::size_t axis) { InstrumentCheck(checked, axis).run(); }

void check_receipt_delays(const Checked& checked) {
  const Config& config = checked.config;
  const auto us = [](can::Duration duration) { return static_cast<double>(duration.count()) * 1e-3; };
  for (const AxisConfig& axis : config.axes) {
    if (axis.twin.apply != node::Apply::receipt) continue;
    const can::Duration& delay = axis.control.delays.command_delay;
    const can::Duration latest = latest_command(plan_bus(config), config, axis);
    if (delay <= can::Duration::zero() || delay > latest)
      checked.fail(delay,
                   "command_delay_us is {:g}, expected more than 0 and at most {:.0f}, the longest time "
                   "from SYNC to the end of the command frame: a setpoint takes effect on receipt",
                   us(delay), us(latest));
  }
}

}  // namespace hystcan::config
