// The settings of an amplifier node and of a sensor node that do not depend on the connected device.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "can/scheduler.h"
#include "node/drive_output.h"

namespace hystcan::node {

/// When a setpoint takes effect at the output of an amplifier.
enum class Apply : std::uint8_t {
  sync,    ///< the setpoint takes effect at the next SYNC (synchronous PDO, CiA 301): always one cycle
           ///< after the SYNC at which the sample for this setpoint was taken
  receipt  ///< the setpoint takes effect when its command frame arrives: earlier than with `sync`, but the
           ///< delay depends on the bus load
};
constexpr auto words(Apply) { return std::to_array<std::string_view>({"sync", "receipt"}); }

/// Settings of the amplifier of one axis.
struct AmplifierConfig {
  can::Duration command_timeout{};  ///< the amplifier trips if no command arrives for this time
  unsigned status_every = 10;       ///< number of SYNCs from one regular AmpStatus to the next
  WatchdogAction watchdog_action = WatchdogAction::safe;
  Apply apply = Apply::sync;
  bool interpolate = false;      ///< true: the output moves to each setpoint in a straight line, in one cycle
  can::Duration enable_delay{};  ///< time from the command Enable until a relay connects the output
  /// Time of the soft start, after `enable_delay`: the output moves evenly to the setpoint. The amplifier is
  /// enabled at the end of this time.
  can::Duration soft_start{};
};

enum class Sampling : std::uint8_t { sync, free };
constexpr auto words(Sampling) { return std::to_array<std::string_view>({"sync", "free"}); }

/// Determines when a sensor takes a sample.
struct SampleClock {
  Sampling sampling = Sampling::sync;
  double rate_Hz = 0.0;   ///< sample rate of the sensor's own clock, > 0; only for Sampling::free
  double skew_ppm = 0.0;  ///< relative speed error of the sensor's own clock; > 0: the clock is fast

  friend bool operator==(const SampleClock&, const SampleClock&) = default;
};

/// Settings that all nodes of one computer share.
struct CommonConfig {
  can::Duration heartbeat_period{};
  /// SYNC period. The amplifier ignores a command with Enable or ClearFault if the SYNC whose counter is in
  /// the command arrived more than two periods ago.
  can::Duration cycle = std::chrono::milliseconds(1);
  /// Number of cycles from one slot of a node to its next slot. A node sends heartbeats and regular statuses
  /// only in its slots. 0: there are no slots, and nodes send at any time.
  unsigned background_slots = 0;
};

}  // namespace hystcan::node
