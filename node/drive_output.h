// The output of an amplifier node: a simulated amplifier, or a digital-analogue converter in front of a real
// amplifier.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "can/scheduler.h"

namespace hystcan::node {

/// What the output does after the commands have stopped, until a command clears the fault.
enum class WatchdogAction : std::uint8_t {
  safe,  ///< the output moves to the safe value as fast as the amplifier can
  hold,  ///< the output stays at the setpoint that is in effect
  ramp,  ///< the output moves to the safe value at the amplifier's ramp rate
  off    ///< the amplifier does not drive the output: the load discharges to zero
};
constexpr auto words(WatchdogAction) {
  return std::to_array<std::string_view>({"safe", "hold", "ramp", "off"});
}

/// The output of one axis. All values are in the unit of the drive, such as V. The caller must pass times
/// that do not decrease from call to call.
class DriveOutput {
 public:
  DriveOutput() = default;
  DriveOutput(const DriveOutput&) = delete;
  DriveOutput& operator=(const DriveOutput&) = delete;
  virtual ~DriveOutput() = default;

  virtual bool reaches(double drive) const = 0;
  /// Connects the output to the actuator. The output has the value that was set last.
  virtual void switch_on() {}
  /// Moves the output to the value `drive` in a straight line, which starts at the time `from` and takes the
  /// time `within`. If `within` is zero, the output gets the value immediately.
  virtual void go_to(double drive, can::Time from, can::Duration within = {}) = 0;
  virtual void leave(WatchdogAction action, can::Time from) = 0;
  virtual double output(can::Time at) = 0;
  /// Called at each SYNC. Returns false if the device has failed or is not allowed to drive the output.
  virtual bool works() { return true; }
};

}  // namespace hystcan::node
