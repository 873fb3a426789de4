// Why an axis is not driven any more: the causes, in the words that log, status frame, telemetry and exit
// reason share. docs/safety.md has the table: how soon each is decided, what follows, which test injects it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace hystcan::controller {

/// On the wire too (ControllerStatus): new ones go to the end.
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
};
inline constexpr std::size_t cause_count = 24;

std::string_view to_string(Cause cause);
/// What the engineer can do about it, in one sentence.
std::string_view remedy(Cause cause);

struct Fault {
  Cause cause = Cause::none;
  double time_s = 0.0;  ///< since the controller's start
};

}  // namespace hystcan::controller
