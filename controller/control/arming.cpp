#include "controller/control/arming.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace hystcan::controller {
namespace {

constexpr double output_error = 0.01;  // of the drive's range

bool is_plausible(double output, const Gate::Config& gate) {
  const double error = output_error * (gate.drive_max - gate.drive_min);
  // With NaN the comparison is false.
  return output >= gate.drive_min - error && output <= gate.drive_max + error;
}

}  // namespace

std::string_view to_string(Lack lack) {
  static constexpr std::array<std::string_view, lack_count> names{
      "nothing",
      "a heartbeat of the sensor",
      "a heartbeat of the amplifier",
      "the sensor to be operational",
      "the amplifier to be operational",
      "the amplifier's fault to be cleared",
      "an amplifier status that says ready",
      "an amplifier output within drive_min..drive_max",
      "an amplifier output at rest",
      "a sample",
      "the amplifier to be enabled",
      "the amplifier's output to follow the drive",
      "the amplifier's watchdog",
      "the other axes"};
  return names[static_cast<std::size_t>(lack)];
}

Lack lack_of(const AxisInput& input, const Gate::Config& gate) {
  const NodeHealth& health = input.health;
  if (!health.sensor_alive) return Lack::sensor_heartbeat;
  if (!health.amplifier_alive) return Lack::amplifier_heartbeat;
  if (!health.sensor_operational) return Lack::sensor_operational;
  if (!health.amplifier_operational) return Lack::amplifier_operational;
  if (health.amplifier_fault) return Lack::clear;
  if (!health.amplifier_ready) return Lack::amplifier_ready;
  if (!is_plausible(health.amplifier_output, gate)) return Lack::amplifier_output;
  if (health.amplifier_moves) return Lack::amplifier_rest;
  return input.position_um ? Lack::nothing : Lack::sample;
}

bool ClearAttempt::step(const NodeHealth& health, double dt_s) {
  const bool goes_on = left_s_ > 0.0;
  if (health.amplifier_operational) left_s_ = std::max(0.0, left_s_ - dt_s);
  return goes_on && health.amplifier_fault;
}

}  // namespace hystcan::controller
