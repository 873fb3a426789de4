// The CANopen life of a node: boot-up, NMT states, heartbeat. Also the monitor of another node's heartbeat.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "can/bus.h"
#include "can/protocol/protocol.h"

namespace hystcan::can {

/// What a boot-up resets.
enum class NmtReset : std::uint8_t {
  node,          ///< everything, as at power-on
  communication  ///< counters and NMT state; what the device keeps for itself stays
};

/// A node that obeys NMT and sends heartbeats. At start() and at each NMT reset it sends a boot-up message
/// and becomes pre-operational. It calls the handler for both states; at boot-up the owner resets what
/// last_reset() says.
///
/// The node is silent before start(). When it receives a heartbeat with its own node id, another node uses
/// that id: it stops, calls the handler and stays silent permanently.
class NmtSlave {
 public:
  using ChangeHandler = std::function<void(NmtState)>;

  NmtSlave(Bus& bus, Scheduler& scheduler, std::uint8_t node, Duration heartbeat_period,
           ChangeHandler on_change);

  void start() { boot_up(NmtReset::node); }
  /// Obeys an NMT frame to this node or to all nodes, detects another node with this node id, and ignores
  /// every other frame.
  void handle(const Frame& frame);
  NmtState state() const { return state_; }
  NmtReset last_reset() const { return last_reset_; }
  /// Another node uses this node id.
  bool is_taken() const { return id_taken_; }
  bool is_silent() const { return !started_ || id_taken_; }

 private:
  void boot_up(NmtReset reset);
  void retire();
  void enter(NmtState state);
  void send_heartbeat();

  Bus& bus_;
  std::uint8_t node_;
  Scheduler& scheduler_;
  Duration period_;
  ChangeHandler on_change_;
  NmtState state_ = NmtState::boot_up;
  NmtReset last_reset_ = NmtReset::node;
  bool started_ = false;
  bool id_taken_ = false;
  std::unique_ptr<Timer> heartbeat_;
};

/// The NMT state of another node by its heartbeats. The caller gives the time; the monitor has no timer.
class HeartbeatMonitor {
 public:
  explicit HeartbeatMonitor(Duration timeout) : timeout_(timeout) {}

  void heard(NmtState state, Time now);
  /// Forgets the state: it is unknown until the next heartbeat.
  void forget() { state_.reset(); }
  /// Empty: no heartbeat has come, or the last one is older than the timeout.
  std::optional<NmtState> state(Time now) const;
  /// Number of boot-up messages received. If it changes, the node has restarted.
  unsigned boot_ups() const { return boot_ups_; }

 private:
  Duration timeout_;
  std::optional<NmtState> state_;
  Time last_{};
  unsigned boot_ups_ = 0;
};

}  // namespace hystcan::can
