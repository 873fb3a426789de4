// The output of an amplifier, driven by its node: simulated, or a converter in front of a real amplifier.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "can/scheduler.h"

namespace hystcan::node {

/// Behaviour of the output after commands have stopped, until a command clears the fault.
enum class WatchdogAction : std::uint8_t {
  safe,  ///< moves to the safe value as fast as the amplifier can
  hold,  ///< stays at the setpoint in effect
  ramp,  ///< moves to the safe value at the amplifier's ramp rate
  off    ///< not driven: the load discharges to zero
};
constexpr auto words(WatchdogAction) {
  return std::to_array<std::string_view>({"safe", "hold", "ramp", "off"});
}

/// Drives are in drive units. The times of successive calls never decrease.
class DriveOutput {
 public:
  DriveOutput() = default;
  DriveOutput(const DriveOutput&) = delete;
  DriveOutput& operator=(const DriveOutput&) = delete;
  virtual ~DriveOutput() = default;

  virtual bool reaches(double drive) const = 0;
  /// Connects the output to the actuator, at the drive that was set last.
  virtual void switch_on() {}
  /// Moves the output to `drive` in a straight line, which starts at `from` and lasts `within`; zero: at
  /// once.
  virtual void go_to(double drive, can::Time from, can::Duration within = {}) = 0;
  virtual void leave(WatchdogAction action, can::Time from) = 0;
  virtual double output(can::Time at) = 0;
  /// Called at each SYNC. Returns false if the device failed or is not allowed to drive.
  virtual bool works() { return true; }
};

}  // namespace hystcan::node
