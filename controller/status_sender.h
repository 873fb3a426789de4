// Sends the ControllerStatus of one axis: with each heartbeat, and when the state of the axis or the cause of
// its fault has changed.
#pragma once

#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "can/protocol/protocol.h"
#include "controller/control/axis.h"

namespace hystcan::controller {

class StatusSender {
 public:
  StatusSender(const can::Database& database, const can::AxisWire& wire);

  /// Returns the identifier of the status; `nullopt` if the database has no such message. In that case, no
  /// status is ever due.
  std::optional<std::uint32_t> id() const;
  /// Makes a status due. Called with each heartbeat.
  void make_due() { due_ = true; }
  bool is_due(const Axis& axis) const;
  /// Returns false if the bus refused the frame, which then stays due.
  bool send(const Axis& axis, can::Bus& bus);
  /// True if `frame` is a valid ControllerStatus of this axis. Only controllers send this message, and a
  /// controller does not receive its own frames. So such a received frame is from another controller.
  bool is_sound(const can::Frame& frame) { return foreign_ && !foreign_->check(frame); }

 private:
  std::optional<can::Encoder<can::ControllerStatus>> encode_;
  std::optional<can::E2eChecker> foreign_;
  bool due_ = false;
  AxisState sent_state_ = AxisState::offline;
  Cause sent_cause_ = Cause::none;
};

}  // namespace hystcan::controller
