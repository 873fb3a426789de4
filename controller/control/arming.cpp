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

Lack lack_of_sensor(const AxisInput& input) {
  if (!input.health.sensor_alive) return Lack::sensor_heartbeat;
  if (!input.health.sensor_operational) return Lack::sensor_operational;
  return input.position_um ? Lack::nothing : Lack::sample;
}

LackSet lacks_of_amplifier(const NodeHealth& health, const Gate::Config& gate) {
  if (!health.amplifier_alive) return Lack::amplifier_heartbeat;
  if (!health.amplifier_operational) return Lack::amplifier_operational;
  if (health.amplifier_fault) return Lack::clear;
  if (!health.amplifier_ready) return Lack::amplifier_ready;
  LackSet lacks;
  if (!is_plausible(health.amplifier_output, gate)) lacks.add(Lack::amplifier_output);
  if (health.amplifier_moves) lacks.add(Lack::amplifier_rest);
  return lacks;
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

std::vector<Lack> LackSet::members() const {
  std::vector<Lack> members;
  for (std::size_t i = 1; i < lack_count; ++i)
    if ((bits_ >> i & 1U) != 0) members.push_back(static_cast<Lack>(i));
  return members;
}

LackSet lacks_of(const AxisInput& input, const Gate::Config& gate) {
  LackSet lacks = lacks_of_amplifier(input.health, gate);
  lacks.add(lack_of_sensor(input));
  return lacks;
}

bool ClearAttempt::step(const NodeHealth& health, double dt_s) {
  const bool goes_on = left_s_ > 0.0;
  if (health.amplifier_operational) left_s_ = std::max(0.0, left_s_ - dt_s);
  return goes_on && health.amplifier_fault;
}

}  // namespace hystcan::controller
