// What the controller sends beside SYNC and commands: its own heartbeat, axis statuses, scan markers, and the
// start-up of nodes.
//
// The queue to the bus is first in, first out, and short. A frame put into it before the commands holds them
// up, and a frame that does not fit is lost. So these frames follow the commands of a cycle, and there is one
// of them at most beside the heartbeat.
//
// Where frames have slots (can::is_in_slot), one heartbeat, status or marker instead follows SYNC in the slot
// of the controller. What belongs to the start-up follows the commands there too.
//
// The start-up brings the remote nodes of waiting axes to operational. A node is set up by SDO first, and
// started by NMT once its set-up is complete. A stopped node answers no SDO; it is sent to pre-operational
// first. A node that axes share is set up by that one which has its objects, as soon as any of them waits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "can/bus.h"
#include "controller/wired_axis.h"

namespace hystcan::controller {

class BackgroundFrames {
 public:
  /// `node`: of the controller's own heartbeat. `slots`: 0 without slots.
  BackgroundFrames(std::uint8_t node, can::Duration heartbeat_period, unsigned slots, WiredAxes& axes)
      : node_(node), heartbeat_period_(heartbeat_period), slots_(slots), axes_(axes) {}

  /// Sends the boot-up message. The first heartbeat follows one period later.
  void start(can::Bus& bus, can::Time now);
  /// Once in a cycle, behind its SYNC.
  void begin_cycle(can::Bus& bus, std::uint8_t sync_counter, can::Time sync_sent);
  /// send_next() has been called in this cycle; true before the first one.
  bool is_done() const { return is_done_; }
  /// Once in a cycle, after its commands. `time_s`: of this cycle's SYNC, since the controller's start.
  void send_next(can::Bus& bus, can::Time sync_sent, can::Time now, double time_s);

 private:
  bool heartbeat_is_due(can::Time sync_sent) const { return sync_sent >= next_heartbeat_; }
  /// All statuses are due with a heartbeat.
  void make_statuses_due();
  void send_heartbeat(can::Bus& bus, can::Time sync_sent);
  bool send_next_scan_marker(can::Bus& bus);
  bool send_next_axis_status(can::Bus& bus);
  /// Of the nodes of waiting axes.
  bool send_next_of_start_up(can::Bus& bus, can::Time now, double time_s);
  /// A node that cannot be set up is a fault of the axes that wait for it, at `time_s`.
  bool send_next_setup_request(can::Bus& bus, can::Time now, double time_s);
  bool send_next_nmt_command(can::Bus& bus, can::Time now);
  /// Each axis has two nodes: its sensor, then its amplifier.
  std::size_t node_count() const { return 2 * axes_.size(); }
  RemoteNode& node_at(std::size_t place) { return *axes_[place / 2]->nodes()[place % 2]; }
  bool some_axis_waits() const;
  /// For each axis that has the node of this number, and for the axis's own view of it.
  void for_each_with(std::uint8_t number, auto visit) const;

  std::uint8_t node_;
  can::Duration heartbeat_period_;
  unsigned slots_;
  WiredAxes& axes_;
  can::Time next_heartbeat_{};
  bool is_done_ = true;
  std::size_t next_status_ = 0;     ///< The axis whose turn it is to report.
  bool sent_status_ = false;        ///< Or a marker, in the last cycle.
  std::size_t next_to_set_up_ = 0;  ///< The nodes take turns.
  std::size_t next_to_command_ =
      0;  ///< Each node gets one NMT command at most in a heartbeat period; the number of
          ///< nodes: all have had their turn.
};

}  // namespace hystcan::controller
