// The nodes of one computer on a bus.
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

  /// Listens for one heartbeat period, then starts all nodes and calls `on_started`. Starts no node if the
  /// bus already has a node with the same number.
  void start(std::function<void()> on_started);
  /// Returns the number of a node that also exists elsewhere on the bus, if there is one.
  std::optional<std::uint8_t> taken_node() const;
  /// Switches every amplifier off; the outputs move to the safe value.
  void shut_down();
  /// Returns the connections of all nodes.
  std::vector<const can::Bus*> connections() const;

 private:
  can::Scheduler& scheduler_;
  can::Duration heartbeat_period_;
  std::function<void()> on_started_;
  std::unique_ptr<can::Timer> listened_;
  std::vector<std::unique_ptr<BusNode>> nodes_;
};

}  // namespace hystcan::node
