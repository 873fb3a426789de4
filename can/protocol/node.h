// The CANopen life of a node: boot-up, NMT states, heartbeat; and the watch kept over another node's
// heartbeat.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "can/bus.h"
#include "can/protocol/protocol.h"

namespace hystcan::can {

/// A node that obeys NMT and beats. On start(), and at each NMT reset, it announces itself (boot-up) and
/// waits, pre-operational; the handler is told of both, so that boot-up is where power-on values are taken up
/// again.
///
/// Before start() it is silent, and so it is again for good once it has heard a heartbeat of its own node id:
/// somebody else is that node. It stops then, and the handler is told.
class NmtSlave {
 public:
  using ChangeHandler = std::function<void(NmtState)>;

  NmtSlave(Bus& bus, Scheduler& scheduler, std::uint8_t node, Duration heartbeat_period,
           ChangeHandler on_change);

  void start();
  /// Obeys an NMT frame that is meant for this node or for all; hears who else is this node; ignores every
  /// other frame.
  void handle(const Frame& frame);
  NmtState state() const { return state_; }
  bool is_taken() const { return taken_; }
  bool is_silent() const { return !started_ || taken_; }

 private:
  void retire();
  void enter(NmtState state);
  void beat();

  Bus& bus_;
  std::uint8_t node_;
  Scheduler& scheduler_;
  Duration period_;
  ChangeHandler on_change_;
  NmtState state_ = NmtState::boot_up;
  bool started_ = false;
  bool taken_ = false;
  std::unique_ptr<Timer> heartbeat_;
};

/// What is known of another node from its heartbeats. Told the time; holds no timer.
class HeartbeatMonitor {
 public:
  explicit HeartbeatMonitor(Duration timeout) : timeout_(timeout) {}

  void heard(NmtState state, Time now);
  /// What was heard no longer counts: the node must beat again.
  void forget() { state_.reset(); }
  /// Empty: never heard, or silent for longer than the timeout.
  std::optional<NmtState> state(Time now) const;
  /// Boot-up messages heard: a change means that the node has restarted.
  unsigned boot_ups() const { return boot_ups_; }

 private:
  Duration timeout_;
  std::optional<NmtState> state_;
  Time last_{};
  unsigned boot_ups_ = 0;
};

}  // namespace hystcan::can
