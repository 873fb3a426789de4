// The connection to one amplifier: its node's heartbeat, its statuses, and the commands to it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "can/dbc/database.h"
#include "can/protocol/protocol.h"
#include "controller/control/axis.h"
#include "controller/remote_node.h"
#include "controller/shared_frames.h"

namespace hystcan::controller {

class AmplifierLink : public RemoteNode {
 public:
  /// `index`: index of the axis.
  AmplifierLink(const can::AxisWire& wire, const Axis& axis, std::size_t index,
                can::Duration heartbeat_timeout, const can::Database& database, SharedFrames& frames);

  Heartbeat on_heartbeat(const can::Frame& frame, can::Time now);
  /// Decodes the status in a frame that statuses() has accepted. Returns true if no event can have caused the
  /// status: it reports the same state as the last one, and this state is not `off`.
  bool on_status(const can::Frame& frame, can::Time now);
  void on_bus_loss(can::BusState state);
  /// Queues the command of this cycle; `nullopt`: the amplifier is not operational. Returns false if the
  /// drive is outside the range of its signal.
  bool put(const std::optional<AxisCommand>& command, std::uint8_t sync_counter);
  /// True if put() was called in this cycle.
  bool is_commanded() const { return commands_.has(place_); }

  /// Fills `input` with the state of amplifier and bus for the next step. Each event since the last step
  /// counts once.
  void take_health(can::Time now, can::BusState bus, AxisInput& input);
  double output() const { return status_.output; }  ///< output in the last status, drive units
  /// Returns the age of the last status at time `at`; NaN if no status has arrived.
  double output_age_s(can::Time at) const;
  CommandFrame& commands() const { return commands_; }
  /// Returns the message with the amplifier's status; null if the amplifier sends none.
  ReceivedFrame* statuses() const { return statuses_; }

 private:
  void forget_status();
  bool reports_a_move(const can::AmpStatus& next) const;

  const Axis& axis_;
  CommandFrame& commands_;
  std::size_t place_;
  std::optional<can::Layout<can::AmpStatus>> layout_;  ///< Empty if the amplifier sends no status.
  ReceivedFrame* statuses_ = nullptr;
  bool reports_output_ = false;  ///< The status contains the output.
  /// The status reports a fault only by its fault flags, because it has no state with this meaning.
  bool flags_report_fault_ = false;
  /// The status that is assumed until the first one arrives, or always if the amplifier sends none.
  can::AmpStatus status_at_first_;
  can::AmpStatus status_;  ///< The last received status.
  /// The next status is the first one: there is no earlier one to compare it with.
  bool is_first_status_ = true;
  can::Time status_heard_{};
  /// The amplifier is enabled or ramping down, so its output may differ from the one in `status_`.
  bool moves_ = false;
  // Events since the last step, even if they lasted only briefly:
  bool fault_seen_ = false;
  bool not_enabled_seen_ = false;
  bool bus_off_seen_ = false;
  bool interface_down_seen_ = false;
};

}  // namespace hystcan::controller
