// All nodes that one computer has on a bus.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/scheduler.h"
#include "node/bus_node.h"

namespace hystcan::node {

class Station {
 public:
  Station(can::Scheduler& scheduler, can::Duration heartbeat_period);

  template <class Made>
  Made& add(std::unique_ptr<Made> node) {
    Made& made = *node;
    nodes_.push_back(std::move(node));
    return made;
  }

  /// Listens to the bus for one heartbeat period, then starts all nodes and calls `on_started`. If the bus
  /// already has another node with the number of a node of this station, start() starts no node and does not
  /// call `on_started`.
  void start(std::function<void()> on_started);
  /// Returns the number of a node of this station if another node on the bus has the same number. Returns
  /// nullopt if no number occurs twice.
  std::optional<std::uint8_t> taken_node() const;
  /// Switches every amplifier off; the outputs move to the safe value.
  void shut_down();
  /// Returns the connection of each node to the bus.
  std::vector<const can::Bus*> connections() const;

 private:
  can::Scheduler& scheduler_;
  can::Duration heartbeat_period_;
  std::function<void()> on_started_;
  std::unique_ptr<can::Timer> listened_;
  std::vector<std::unique_ptr<BusNode>> nodes_;
};

}  // namespace hystcan::node
