// The controller's own frames of one axis, where the database has them: ControllerStatus out, Setpoint in.
//
//   ControllerStatus   with each heartbeat, and when state or cause have changed
//   Setpoint           obeyed where the configuration says so; what is refused is counted by its reason
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "can/bus.h"
#include "can/protocol/protocol.h"
#include "controller/control/axis.h"

namespace hystcan::controller {

/// What the axis says of itself. The following error is held within the width of the plausible positions.
can::ControllerStatus status_of(const Axis& axis);

/// When the status is to be sent, and its sender.
class StatusSender {
 public:
  StatusSender(const can::Database& database, const can::AxisWire& wire);

  /// Identifier of the status. Empty: the database has none, nothing is ever due.
  std::optional<std::uint32_t> id() const;
  /// A heartbeat goes out.
  void make_due() { due_ = true; }
  bool is_due(const Axis& axis) const;
  /// False: the bus did not take it; it stays due.
  bool send(const Axis& axis, can::Bus& bus);
  /// A sound one that was heard is another controller's.
  bool is_sound(const can::Frame& frame) { return foreign_ && !foreign_->check(frame); }

 private:
  std::optional<can::Encoder<can::ControllerStatus>> encode_;
  std::optional<can::E2eChecker> foreign_;
  bool due_ = false;
  AxisState told_state_ = AxisState::offline;
  Cause told_cause_ = Cause::none;
};

/// Of the live setpoints that were sound as frames.
struct SetpointCounters {
  std::uint64_t taken = 0;
  std::uint64_t not_tracking = 0;
  std::uint64_t out_of_range = 0;
  std::uint64_t unknown_mode = 0;

  std::uint64_t refused() const { return not_tracking + out_of_range + unknown_mode; }
};
/// "2 live setpoints taken, refused: 1 not tracking, 3 out of range"; empty where none came.
std::string describe(const SetpointCounters& counters);

/// Hears live setpoints for one axis.
class SetpointReceiver {
 public:
  /// Throws std::invalid_argument where the database has no such message.
  SetpointReceiver(const can::Database& database, const can::AxisWire& wire);

  void hear(const can::Frame& frame, Axis& axis);
  std::uint32_t id() const { return decode_.id(); }
  const can::E2eChecker& checker() const { return decode_.checker(); }
  const SetpointCounters& counters() const { return counters_; }

 private:
  can::Decoder<can::Setpoint> decode_;
  SetpointCounters counters_;
};

}  // namespace hystcan::controller
