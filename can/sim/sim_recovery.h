// Recovery from bus-off on the simulated bus (ISO 11898-1): a restart request, then 128 times 11 recessive
// bits. Internal to the simulated bus.
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

  /// `restart_after` is the time from bus-off to the automatic restart request; empty: there is none.
  /// `on_timer` is called when a node must request its restart or has recovered.
  BusOffRecovery(VirtualClock& clock, double bit_ns, std::optional<Duration> restart_after,
                 TimerHandler on_timer);

  bool any_off() const { return nodes_off_ != 0; }
  void go_off(Node& node);
  /// `recessive_since` is empty while a frame is on the wire.
  void request_restart(Node& node, std::optional<Time> recessive_since);
  /// Counts the recessive bits up to now.
  void frame_begins(Nodes nodes);
  /// Every frame, whole or destroyed, ends with eleven recessive bits, of which three are interframe space.
  void frame_ended(Nodes nodes, Time free_at);
  void come_back(Node& node);
  /// The node is detached from the wire.
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
