// What a configuration puts on the bus, and whether every command makes its cycle. docs/theory.md,
// section 12.
//
//   SYNC(n) -> SensorSample(n) -> AmpCommand(n)      within the cycle T, per axis
//
// A command makes its cycle where it has begun by the next SYNC: what has begun is through before that SYNC.
// can/timing/chain.h bounds when, and says what is assumed; can/timing/schedulability.h has the other frames.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "can/timing/schedulability.h"
#include "config/document/document.h"
#include "config/schema/config.h"

namespace hystcan::config {

/// A frame on the bus, with what the table of `hystcan check` says of it.
struct PlannedFrame {
  can::PeriodicFrame frame;
  can::Duration transmission{};
  /// Worst case, up to the end of the interframe space: of SYNC, samples and commands from the start of the
  /// cycle, of the others from when they are queued. Empty: without bound.
  std::optional<can::Duration> response;
  can::Duration deadline{};

  bool in_time() const { return response && *response <= deadline; }
};

struct BusPlan {
  std::vector<PlannedFrame> frames;       ///< by priority, emergencies left out
  std::vector<PlannedFrame> emergencies;  ///< beside all others
  double load = 0.0;                      ///< of `frames`, every stuff bit counted
  can::Duration cycle{};
  std::optional<can::Duration> last_command;  ///< the latest beginning of a command in its cycle

  bool commands_in_time() const { return last_command && *last_command <= cycle; }
};

/// Throws std::invalid_argument where the database lacks a message or two frames share an identifier.
BusPlan plan_bus(const Config& config);

/// Throws Error at the rate where a command cannot make its cycle.
void check_bus(const Document& document, const Config& config);

}  // namespace hystcan::config
