// The settings of an amplifier node and of a sensor node, independent of the device.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "can/scheduler.h"
#include "node/drive_output.h"

namespace hystcan::node {

/// When a setpoint takes effect.
enum class Apply : std::uint8_t {
  sync,    ///< at the next SYNC (synchronous PDO, CiA 301): always one cycle after the SYNC that the command
           ///< answers
  receipt  ///< when its frame arrives: earlier, but the delay depends on the bus load
};
constexpr auto words(Apply) { return std::to_array<std::string_view>({"sync", "receipt"}); }

/// The amplifier of one axis.
struct AmplifierConfig {
  can::Duration command_timeout{};  ///< the amplifier trips if no command arrives for this time
  unsigned status_every = 10;       ///< number of SYNCs per AmpStatus
  WatchdogAction watchdog_action = WatchdogAction::safe;
  Apply apply = Apply::sync;
  bool interpolate = false;      ///< moves in a straight line to each setpoint within a cycle
  can::Duration enable_delay{};  ///< time from Enable until a relay connects the output
  /// After `enable_delay` the output moves evenly to its setpoint; the amplifier is enabled at the end.
  can::Duration soft_start{};
};

enum class Sampling : std::uint8_t { sync, free };
constexpr auto words(Sampling) { return std::to_array<std::string_view>({"sync", "free"}); }

/// When a sensor samples.
struct SampleClock {
  Sampling sampling = Sampling::sync;
  double rate_Hz = 0.0;   ///< free-running: rate of the sensor's own clock, > 0
  double skew_ppm = 0.0;  ///< relative speed error of that clock; > 0: the clock is fast

  friend bool operator==(const SampleClock&, const SampleClock&) = default;
};

/// Settings that all nodes of a computer share.
struct CommonConfig {
  can::Duration heartbeat_period{};
  can::Duration cycle = std::chrono::milliseconds(1);  ///< SYNC period; amplifiers need it
  unsigned background_slots = 0;                       ///< slots for heartbeats and statuses
                                                       ///< (can::is_in_slot)
};

}  // namespace hystcan::node
