// Brings the remote nodes of waiting axes to operational. A node is set up by SDO first, and started by NMT
// once its set-up is complete. A stopped node answers no SDO; it is sent to pre-operational first.
#pragma once

#include <cstddef>

#include "can/bus.h"
#include "controller/wired_axis.h"

namespace hystcan::controller {

class NodeStartUp {
 public:
  /// Places in the list of all nodes. Each axis has two: its sensor, then its amplifier.
  struct State {
    std::size_t next_to_set_up = 0;   ///< The nodes take turns.
    std::size_t next_to_command = 0;  ///< Each node gets one NMT command at most in a heartbeat period; the
                                      ///< number of nodes: all have had their turn.
  };

  explicit NodeStartUp(WiredAxes& axes) : axes_(axes) {}

  /// A new heartbeat period begins: if every node has had its turn of the NMT commands, the turns begin
  /// again.
  void begin_period();
  /// Once in a cycle: sends one frame at most, an SDO request before an NMT command. Returns whether a frame
  /// was sent. A node that cannot be set up is a fault of its axis, at `time_s`.
  bool send_next(can::Bus& bus, can::Time now, double time_s);

  const State& state() const { return state_; }

 private:
  bool send_next_setup_request(can::Bus& bus, can::Time now, double time_s);
  bool send_next_command(can::Bus& bus, can::Time now);
  std::size_t node_count() const { return 2 * axes_.size(); }
  RemoteNode& node_at(std::size_t place);

  WiredAxes& axes_;
  State state_;
};

}  // namespace hystcan::controller
