// The settings of an amplifier node and of a sensor node, whatever device is behind them.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "can/scheduler.h"
#include "node/drive_output.h"

namespace hystcan::node {

/// When a setpoint takes effect.
enum class Apply : std::uint8_t {
  sync,    ///< at the next SYNC (synchronous PDO, CiA 301): always one cycle after the SYNC that it answers
  receipt  ///< when its frame arrives: sooner, but the delay depends on the bus
};
constexpr auto words(Apply) { return std::to_array<std::string_view>({"sync", "receipt"}); }

/// The amplifier of one axis.
struct AmplifierConfig {
  can::Duration command_timeout{};  ///< the amplifier trips if no command arrives for this time
  unsigned status_every = 10;       ///< number of SYNCs per AmpStatus
  WatchdogAction watchdog_action = WatchdogAction::safe;
  Apply apply = Apply::sync;
  bool interpolate = false;      ///< moves to a setpoint in a straight line within a cycle
  can::Duration enable_delay{};  ///< from Enable until the output is connected, by a relay
  /// From there the output goes evenly to its setpoint; only then it is enabled.
  can::Duration soft_start{};
};

enum class Sampling : std::uint8_t { sync, free };
constexpr auto words(Sampling) { return std::to_array<std::string_view>({"sync", "free"}); }

/// When a sensor samples.
struct SampleClock {
  Sampling sampling = Sampling::sync;
  double rate_Hz = 0.0;   ///< free-running: by its own clock, > 0
  double skew_ppm = 0.0;  ///< relative speed error of that clock; > 0: it is fast

  friend bool operator==(const SampleClock&, const SampleClock&) = default;
};

/// Common to all nodes of a computer.
struct CommonConfig {
  can::Duration heartbeat_period{};
  can::Duration cycle = std::chrono::milliseconds(1);  ///< of the SYNCs, as set in an amplifier
  unsigned background_slots = 0;                       ///< of heartbeats and statuses (can::is_in_slot)
};

}  // namespace hystcan::node
