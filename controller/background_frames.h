// Sends all frames except SYNC and commands: the controller's own heartbeat, axis statuses, scan markers, and
// the frames that start up nodes.
//
// The queue to the bus is short and first in, first out. A frame that is queued before the commands delays
// the commands, and a frame that does not fit into the queue is lost. Therefore these frames follow the
// commands of a cycle, and at most one of them is sent in a cycle in addition to the heartbeat.
//
// If frames have slots (can::is_in_slot), the controller sends a heartbeat, a status or a marker only
// directly after the SYNC of its own slot. The frames of the start-up still follow the commands.
//
// The start-up brings the remote nodes of waiting axes to the state operational. A node is set up by SDO
// first, and started by NMT when its set-up is complete. A stopped node does not answer SDO requests; it is
// first sent to the state pre-operational. If several axes share a node, one of them has the SDO objects of
// the node. This axis sets the node up as soon as any of the axes waits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "can/bus.h"
#include "controller/wired_axis.h"

namespace hystcan::controller {

class BackgroundFrames {
 public:
  /// `node`: id of the controller's own heartbeat. `slots`: number of slots; 0: no slots.
  BackgroundFrames(std::uint8_t node, can::Duration heartbeat_period, unsigned slots, WiredAxes& axes)
      : node_(node), heartbeat_period_(heartbeat_period), slots_(slots), axes_(axes) {}

  /// Sends the boot-up message. The first heartbeat follows one period later.
  void start(can::Bus& bus, can::Time now);
  /// Begins a cycle. With slots, sends a frame if this is the controller's slot. Called once per cycle, after
  /// its SYNC.
  void begin_cycle(can::Bus& bus, std::uint8_t sync_counter, can::Time sync_sent);
  /// True if send_next() was called in this cycle; also true before the first cycle.
  bool is_done() const { return is_done_; }
  /// Sends the next frames. Called once per cycle, after its commands. `time_s`: time of this cycle's SYNC
  /// since the controller's start.
  void send_next(can::Bus& bus, can::Time sync_sent, can::Time now, double time_s);

 private:
  bool heartbeat_is_due(can::Time sync_sent) const { return sync_sent >= next_heartbeat_; }
  /// Makes the statuses of all axes due. Called with each heartbeat.
  void make_statuses_due();
  void send_heartbeat(can::Bus& bus, can::Time sync_sent);
  bool send_next_scan_marker(can::Bus& bus);
  bool send_next_axis_status(can::Bus& bus);
  /// Sends the next set-up request or NMT command to a node of a waiting axis.
  bool send_next_of_start_up(can::Bus& bus, can::Time now, double time_s);
  /// Sends the next SDO request of a set-up. If a node cannot be set up, trips the axes that wait for it;
  /// `time_s` is then the time of the fault.
  bool send_next_setup_request(can::Bus& bus, can::Time now, double time_s);
  bool send_next_nmt_command(can::Bus& bus, can::Time now);
  /// Each axis has two nodes: first its sensor, then its amplifier.
  std::size_t node_count() const { return 2 * axes_.size(); }
  RemoteNode& node_at(std::size_t place) { return *axes_[place / 2]->nodes()[place % 2]; }
  bool some_axis_waits() const;
  /// Calls `visit` for each axis that uses the node with this id. Axes can share a node; each of them has its
  /// own RemoteNode object for it, which is passed to `visit`.
  void for_each_with(std::uint8_t number, auto visit) const;

  std::uint8_t node_;
  can::Duration heartbeat_period_;
  unsigned slots_;
  WiredAxes& axes_;
  can::Time next_heartbeat_{};
  bool is_done_ = true;
  std::size_t next_status_ = 0;  ///< Index of the axis that may send its next status; they take turns.
  /// True if a status or a scan marker was sent in the last cycle. The start-up then has its turn.
  bool sent_status_ = false;
  std::size_t next_to_set_up_ = 0;  ///< Index of the node that is set up next; the nodes take turns.
  /// Index of the node that gets the next NMT command. Each node gets at most one per heartbeat period. The
  /// value node_count() means that all nodes have had their turn in this period.
  std::size_t next_to_command_ = 0;
};

}  // namespace hystcan::controller
