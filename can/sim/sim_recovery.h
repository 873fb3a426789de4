// The way back from bus-off on the simulated bus (ISO 11898-1): a restart request, then 128 times 11
// recessive bits. Internal to the simulated bus.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "can/sim/sim_fate.h"
#include "can/sim/sim_node.h"

namespace hystcan::can::sim {

class BusOffRecovery {
 public:
  using TimerHandler = std::function<void(Node& node)>;

  /// `restart_after`: from bus-off to the restart request; empty: none comes by itself. `on_timer`: a node's
  /// time has come, to ask for its restart or to come back.
  BusOffRecovery(VirtualClock& clock, double bit_ns, std::optional<Duration> restart_after,
                 TimerHandler on_timer);

  bool any_off() const { return nodes_off_ != 0; }
  void go_off(Node& node);
  /// `recessive_since`: empty where a frame is on the wire.
  void request_restart(Node& node, std::optional<Time> recessive_since);
  /// What has stood recessive up to now counts.
  void frame_begins(Nodes nodes);
  /// Every frame, whole or destroyed, ends in eleven recessive bits, the interframe space the last of them.
  void frame_ended(Nodes nodes, Time free_at);
  void come_back(Node& node);
  /// The node is taken off the wire.
  void forget(const Node& node);

 private:
  void expect_recessive(Node& node, Time since) const;

  VirtualClock& clock_;
  double bit_ns_;
  std::optional<Duration> restart_after_;
  TimerHandler on_timer_;
  std::size_t nodes_off_ = 0;
};

}  // namespace hystcan::can::sim
