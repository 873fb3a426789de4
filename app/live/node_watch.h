// Logs the states of the amplifiers and of the bus, for a process that contains CAN nodes (the twin, or
// `hystcan node`).
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "can/bus_health_log.h"
#include "can/protocol/protocol.h"
#include "node/amplifier_channel.h"
#include "node/station.h"

namespace hystcan::app {

struct WatchedAmplifier {
  can::AxisWire wire;
  const node::AmplifierChannel* amplifier = nullptr;
};

class NodeWatch {
 public:
  /// Starts the log. Calls `on_taken` if another device on the bus uses the node number of a node in
  /// `station`.
  NodeWatch(const node::Station& station, std::vector<WatchedAmplifier> amplifiers, can::Scheduler& scheduler,
            const std::string& interface, std::function<void()> on_taken);

  void log_bus();

 private:
  void look();

  const node::Station& station_;
  std::vector<WatchedAmplifier> amplifiers_;
  can::Scheduler& scheduler_;
  can::Time started_;
  std::vector<can::AmpState> seen_;
  can::BusHealthLog bus_log_;
  std::function<void()> on_taken_;
  std::unique_ptr<can::Timer> timer_;
};

/// Returns the lines to print at the end of a run: the state of the bus, and the rejected commands of each
/// amplifier node.
std::string closing_text(const node::Station& station, const std::vector<WatchedAmplifier>& amplifiers);

/// Throws RunError if another device on the bus uses the node number of a node in `station`.
void refuse_if_taken(const node::Station& station, const std::string& interface);

}  // namespace hystcan::app
