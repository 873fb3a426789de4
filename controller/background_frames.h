// What the controller sends beside SYNC and commands.
#pragma once

#include <cstddef>
#include <cstdint>

#include "can/bus.h"
#include "controller/wired_axis.h"

namespace hystcan::controller {

// Brings the remote nodes of waiting axes to operational. A node is set up by SDO first, and started by NMT
// once its set-up is complete. A stopped node answers no SDO; it is sent to pre-operational first.

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

// What the controller sends beside SYNC and commands: its own heartbeat, axis statuses, scan markers, and the
// start-up of nodes.
//
// The queue to the bus is first in, first out, and short. A frame put into it before the commands holds them
// up, and a frame that does not fit is lost. So these frames follow the commands of a cycle, and there is one
// of them at most beside the heartbeat.

class BackgroundFrames {
 public:
  struct Config {
    std::uint8_t node = 127;  ///< Of the controller's own heartbeat.
    can::Duration heartbeat_period{std::chrono::milliseconds(100)};
  };
  struct State {
    can::Time next_heartbeat{};
    std::size_t next_status = 0;  ///< The axis whose turn it is to report.
    bool sent_status = false;     ///< Or a marker, in the last cycle.
  };

  BackgroundFrames(const Config& config, WiredAxes& axes) : config_(config), axes_(axes), start_up_(axes) {}

  /// Sends the boot-up message. The first heartbeat follows one period later.
  void start(can::Bus& bus, can::Time now);
  /// Once in a cycle, after its commands. `time_s`: of this cycle's SYNC, since the controller's start.
  void send_next(can::Bus& bus, can::Time sync_sent, can::Time now, double time_s);

  const State& state() const { return state_; }

 private:
  bool send_next_scan_marker(can::Bus& bus);
  bool send_next_axis_status(can::Bus& bus);

  Config config_;
  WiredAxes& axes_;
  NodeStartUp start_up_;
  State state_;
};

}  // namespace hystcan::controller
