// Computes when each frame of a configuration is sent on the bus, and checks that every command is in time.
// The derivation is in docs/theory/bus.md. The frames of control cycle n follow each other within the cycle:
//
//   SYNC(n) -> SensorSample(n) -> AmpCommand(n)
//
// A command is in time if its transmission begins before the next SYNC: a frame that has begun ends before
// that SYNC is sent. can/timing/chain.h computes upper bounds for the start of the command and for the
// response times of all other frames, and lists the assumptions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "can/timing/schedulability.h"
#include "config/schema/config.h"

namespace hystcan::config {

/// A frame on the bus with its timing. `hystcan check` prints a row of its table for each such frame.
struct PlannedFrame {
  can::PeriodicFrame frame;
  can::Duration transmission{};
  /// Worst-case time until the frame and its interframe space are sent; nullopt if there is no upper bound.
  /// The time of SYNC, samples and commands counts from the start of the cycle, the time of other frames from
  /// queueing.
  std::optional<can::Duration> response;
  can::Duration deadline{};

  bool in_time() const { return response && *response <= deadline; }
};

struct BusPlan {
  std::vector<PlannedFrame> frames;       ///< all frames except emergencies, highest priority first
  std::vector<PlannedFrame> emergencies;  ///< emergency frames, sent in addition to `frames`
  double load = 0.0;  ///< bus load by `frames`, 1: bus is full; with all possible stuff bits
  can::Duration cycle{};
  std::optional<can::Duration> last_command;  ///< longest time from a SYNC to the start of its last command
                                              ///< frame; nullopt: there is no upper bound

  bool commands_in_time() const { return last_command && *last_command <= cycle; }
};

/// Computes the timing of all frames. Throws std::invalid_argument if the database lacks a message, or if two
/// frames have the same identifier.
BusPlan plan_bus(const Config& config);

/// Returns the longest time between two AmpStatus frames of the axis. Without background slots, this is
/// `status_every` cycles; if twin and analogue node have different values, the larger one counts. With
/// background slots, the frames wait for the slot of their node: the time is the number of rounds that the
/// node needs for its status messages and its heartbeats.
can::Duration longest_status_period(const Config& config, const AxisConfig& axis);

/// Returns the highest cycle rate at which all commands are in time, at most the configured rate. A lower
/// rate is rounded down to 1 Hz, or to 10 Hz above 100 Hz. Returns 0 if the commands are late even at 1 Hz.
double fastest_rate_Hz(Config config);

}  // namespace hystcan::config
