// The amplifier's node, its statuses, and the commands to it.
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
  /// `index`: of the axis.
  AmplifierLink(const can::AxisWire& wire, const Axis& axis, std::size_t index,
                can::Duration heartbeat_timeout, const can::Database& database, SharedFrames& frames);

  Heartbeat on_heartbeat(const can::Frame& frame, can::Time now);
  /// The status in a frame that statuses() has accepted. True for the state of the status before, but for
  /// off: a status that no event has caused.
  bool on_status(const can::Frame& frame, can::Time now);
  void on_bus_loss(can::BusState state);
  /// Of this cycle. Empty: the amplifier sleeps. False: the drive does not fit its signal.
  bool put(const std::optional<AxisCommand>& command, std::uint8_t sync_counter);
  /// This cycle's command has been put.
  bool is_commanded() const { return commands_.has(place_); }

  /// What is known for the next step. Each event since the last step counts once.
  void take_health(can::Time now, can::BusState bus, AxisInput& input);
  double output() const { return status_.output; }  ///< of the last status, drive units
  /// Age of the last status at this time; NaN if none has arrived.
  double output_age_s(can::Time at) const;
  CommandFrame& commands() const { return commands_; }
  /// Null: the amplifier sends no status.
  ReceivedFrame* statuses() const { return statuses_; }

 private:
  void forget_status();
  bool reports_a_move(const can::AmpStatus& next) const;

  const Axis& axis_;
  CommandFrame& commands_;
  std::size_t place_;
  std::optional<can::Layout<can::AmpStatus>> layout_;  ///< Empty: the amplifier sends no status.
  ReceivedFrame* statuses_ = nullptr;
  bool reports_output_ = false;      ///< The status carries the output.
  bool flags_report_fault_ = false;  ///< The state field alone does not report a fault.
  can::AmpStatus status_at_first_;   ///< What holds before a status comes, or where none ever comes.
  can::AmpStatus status_;            ///< The last one received.
  bool is_first_status_ = true;      ///< The next one; there is none to compare it with.
  can::Time status_heard_{};
  bool moves_ = false;  ///< Enabled, or ramping down: `status_` does not say where the output is.
  // Since the last step, however briefly:
  bool fault_seen_ = false;
  bool not_enabled_seen_ = false;
  bool bus_off_seen_ = false;
  bool interface_down_seen_ = false;
};

}  // namespace hystcan::controller
