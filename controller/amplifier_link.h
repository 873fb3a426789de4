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
  /// `index`: index of the axis in the controller.
  AmplifierLink(const can::AxisWire& wire, const Axis& axis, std::size_t index,
                can::Duration heartbeat_timeout, const can::Database& database, SharedFrames& frames);

  Heartbeat on_heartbeat(const can::Frame& frame, can::Time now);
  /// Decodes the status in a frame that statuses() has accepted. Returns true if the status is periodic: it
  /// reports the same state as the last status, and this state is not `off`. The node must send a periodic
  /// status in its own slot. It may send a status with a new state at any time.
  bool on_status(const can::Frame& frame, can::Time now);
  void on_bus_loss(can::BusState state);
  /// Puts the command of this cycle into its frame. `nullopt`: the amplifier is not operational. Returns
  /// false if the drive is outside the range of its signal.
  bool put(const std::optional<AxisCommand>& command, std::uint8_t sync_counter);
  /// True if put() has been called in this cycle.
  bool is_commanded() const { return commands_.has(place_); }

  /// Fills `input` with the state of amplifier and bus for the next step of the axis. An event since the last
  /// step is reported once.
  void take_health(can::Time now, can::BusState bus, AxisInput& input);
  double output() const { return status_.output; }  ///< output that the last status reported, drive units
  /// Returns the age of the last status at time `at`; NaN if no status has arrived.
  double output_age_s(can::Time at) const;
  CommandFrame& commands() const { return commands_; }
  /// Returns the received message that contains the amplifier's status; null if the amplifier sends no
  /// status.
  ReceivedFrame* statuses() const { return statuses_; }

 private:
  void forget_status();
  bool reports_a_move(const can::AmpStatus& next) const;

  const Axis& axis_;
  CommandFrame& commands_;
  std::size_t place_;
  /// Layout of the status; empty if the amplifier sends no status.
  std::optional<can::Layout<can::AmpStatus>> layout_;
  ReceivedFrame* statuses_ = nullptr;
  bool reports_output_ = false;  ///< True if the status contains the output.
  /// True if only the fault flags of the status can report a fault: the status has no `state`, or no value of
  /// `state` is configured as a fault.
  bool flags_report_fault_ = false;
  /// The status that is assumed until the first status arrives, or always if the amplifier sends no status.
  can::AmpStatus status_at_first_;
  can::AmpStatus status_;  ///< The last received status.
  /// True until the first status arrives, which cannot be compared with an earlier status.
  bool is_first_status_ = true;
  can::Time status_heard_{};
  /// True while the amplifier is enabled or ramps down: its output may then differ from the output in
  /// `status_`.
  bool moves_ = false;
  // Each of the following four is true if its event (a fault, a state other than enabled, bus-off, interface
  // down) has occurred since the last step of the axis, even if the event was brief.
  bool fault_seen_ = false;
  bool not_enabled_seen_ = false;
  bool bus_off_seen_ = false;
  bool interface_down_seen_ = false;
};

}  // namespace hystcan::controller
