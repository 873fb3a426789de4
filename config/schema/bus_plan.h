// The frames that a configuration sends on the bus, and the check that every command is in time. Derivation:
// docs/theory/bus.md.
//
//   SYNC(n) -> SensorSample(n) -> AmpCommand(n)      within the cycle T, per message
//
// A command is in time if its transmission begins before the next SYNC: a frame that has begun ends before
// that SYNC is sent. can/timing/chain.h bounds the start of the command and the responses of the other
// frames, and lists the assumptions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "can/timing/schedulability.h"
#include "config/schema/config.h"

namespace hystcan::config {

/// A frame on the bus, which is a row in the table of `hystcan check`.
struct PlannedFrame {
  can::PeriodicFrame frame;
  can::Duration transmission{};
  /// Worst-case time to the end of the interframe space, from the start of the cycle for SYNC, samples and
  /// commands, and from queueing for all other frames; nullopt if unbounded.
  std::optional<can::Duration> response;
  can::Duration deadline{};

  bool in_time() const { return response && *response <= deadline; }
};

struct BusPlan {
  std::vector<PlannedFrame> frames;       ///< by priority, without emergencies
  std::vector<PlannedFrame> emergencies;  ///< each in addition to all `frames`
  double load = 0.0;                      ///< load of `frames` with the maximum number of stuff bits
  can::Duration cycle{};
  std::optional<can::Duration> last_command;  ///< latest start of a command in its cycle

  bool commands_in_time() const { return last_command && *last_command <= cycle; }
};

/// Throws std::invalid_argument if the database lacks a message, or if two frames share an identifier.
BusPlan plan_bus(const Config& config);

/// Returns the longest time between two AmpStatus of the axis: `status_every` cycles (the larger value of
/// twin and node) or, with slots, as many whole rounds as its node needs to send each of its status messages
/// and its heartbeats.
can::Duration longest_status_period(const Config& config, const AxisConfig& axis);

/// Returns the highest rate, up to the configured one, at which all commands are in time, rounded down to 1
/// Hz or, from 100 Hz, to 10 Hz; 0 if not even 1 Hz is possible.
double fastest_rate_Hz(Config config);

}  // namespace hystcan::config
