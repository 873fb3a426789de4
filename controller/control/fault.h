// The causes of a fault: the reasons for which the controller stops driving an axis. Log, status frame,
// telemetry and exit reason use the same names. A table in docs/safety.md lists for each cause the detection
// time, the reaction, and the test that injects the cause.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace hystcan::controller {

/// The status frame ControllerStatus contains the number of the cause. Therefore append new causes at the
/// end.
enum class Cause : std::uint8_t {
  none,
  interface_down,
  bus_off,
  cycle_overrun,
  sample_missing,
  sensor_status,
  position_implausible,
  sensor_silent,
  amplifier_silent,
  node_restarted,
  node_not_set_up,
  amplifier_fault,
  amplifier_not_enabled,
  following_error,
  command_not_sendable,
  another_controller,
  sample_late,
  position_frozen,
  position_jumped,
  node_emergency,
  node_not_operational,
  bus_passive,
  saturated,
  model_left_range,
  watchdog_failed,
  commands_late,
  sample_doubled,
  status_missing,
  foreign_access,
  loop_unstable,
  output_differs,
  position_contradicts,
};
inline constexpr std::size_t cause_count = 32;

std::string_view to_string(Cause cause);
/// Returns a sentence that tells the user how to remove this cause.
std::string_view remedy(Cause cause);
/// True if amplifier, bus and computer still work after a fault with this cause, so that the drive may ramp
/// to its safe value.
bool leaves_the_drive_in_hand(Cause cause);

struct Fault {
  Cause cause = Cause::none;
  double time_s = 0.0;  ///< time of the fault, since the controller's start
};

}  // namespace hystcan::controller
