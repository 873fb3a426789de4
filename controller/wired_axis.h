// One axis with its place on the bus: the axis itself, and the links to its two nodes with the codecs of
// their frames.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/dbc/database.h"
#include "can/protocol/protocol.h"
#include "controller/command_frame.h"
#include "controller/control/axis.h"
#include "controller/cycle_record.h"
#include "controller/remote_node.h"
#include "controller/scan_marker_sender.h"
#include "controller/setpoint_receiver.h"
#include "controller/status_sender.h"

namespace hystcan::controller {

struct WiredAxisConfig {
  can::AxisWire wire;
  AxisConfig axis;
  bool live_setpoint = false;  ///< The axis obeys Setpoint frames, whoever sends them.
  bool scan_marker = false;    ///< A ScanMarker is sent for each line of a scan.
};

/// The sensor's node and its samples.
class SensorLink : public RemoteNode {
 public:
  SensorLink(const can::AxisWire& wire, can::Duration heartbeat_timeout, const can::Database& database);

  Heartbeat on_heartbeat(const can::Frame& frame, can::Time now);
  /// Empty where the frame is damaged, or names a SYNC that there is not; the log says so.
  std::optional<can::SensorSample> on_sample(const can::Frame& frame, std::uint64_t cycle);
  /// The last sample and another one, both accepted, name the same SYNC. A frame that is sent twice is no
  /// other one.
  bool is_doubled() const { return is_doubled_; }
  /// False: the sample is of another cycle. Where samples do not name their SYNC, they count for the cycle in
  /// which they arrive.
  bool is_of(const can::SensorSample& sample, std::uint8_t sync_counter) const {
    return !names_its_sync_ || sample.sync_counter == sync_counter;
  }
  void note_late_sample() { late_sample_ = true; }
  /// The bus was off or the interface down: what is known of the node may no longer hold.
  void on_bus_loss();

  /// What is known for the next step. Each event since the last step counts once.
  void take_health(can::Time now, AxisInput& input);
  const can::Decoder<can::SensorSample>& decoder() const { return decode_; }

 private:
  struct NamedSync {
    std::uint64_t cycle = 0;  ///< 0: none yet
    can::Frame frame{};
  };

  can::Decoder<can::SensorSample> decode_;
  bool names_its_sync_;
  bool is_doubled_ = false;
  bool late_sample_ = false;                  ///< A sample came too late since the last step.
  std::array<NamedSync, 256> named_syncs_{};  ///< by SyncCounter: the last sample that named it
};

/// The amplifier's node, its statuses, and the commands to it.
class AmplifierLink : public RemoteNode {
 public:
  /// `place`: of the axis in the frame of its commands.
  AmplifierLink(const can::AxisWire& wire, const Axis& axis, can::Duration heartbeat_timeout,
                const can::Database& database, CommandFrame& commands, std::size_t place);

  Heartbeat on_heartbeat(const can::Frame& frame, can::Time now);
  /// True for the state of the status before, but for off: a status that no event has caused.
  bool on_status(const can::Frame& frame, can::Time now);
  void on_bus_loss(can::BusState state);
  /// Of this cycle. Empty: the amplifier sleeps. False: the drive does not fit its signal.
  bool put(const std::optional<AxisCommand>& command, std::uint8_t sync_counter);

  /// What is known for the next step. Each event since the last step counts once.
  void take_health(can::Time now, can::BusState bus, AxisInput& input);
  double output() const { return status_.output; }  ///< of the last status, drive units
  /// Age of the last status at this time; NaN if none has arrived.
  double output_age_s(can::Time at) const;
  CommandFrame& commands() const { return commands_; }
  /// Empty: the amplifier sends no status.
  const std::optional<can::Decoder<can::AmpStatus>>& decoder() const { return decode_; }

 private:
  void forget_status();
  bool reports_a_move(const can::AmpStatus& next) const;

  const Axis& axis_;
  CommandFrame& commands_;
  std::size_t place_;
  std::optional<can::Decoder<can::AmpStatus>> decode_;
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

struct WiredAxis {
  /// Throws std::invalid_argument where the database lacks a message or the model is not valid.
  WiredAxis(const WiredAxisConfig& config, can::Duration heartbeat_timeout, const can::Database& database,
            CommandFrame& commands, std::size_t place);
  WiredAxis(const WiredAxis&) = delete;
  WiredAxis& operator=(const WiredAxis&) = delete;
  ~WiredAxis() = default;

  std::array<RemoteNode*, 2> nodes() { return {&sensor, &amplifier}; }
  /// Faults the axis, unless it is offline; ends the ramp of a faulted one. The log names the frame, once in
  /// a fault.
  void on_another_controller(const ForeignFrame& frame, double time_s);
  /// The oldest event not yet taken, of amplifier and sensor in turn; first the frame of another controller.
  std::optional<NodeEvent> take_event();
  /// Of every message of this axis that the controller receives.
  void append_rejected(std::vector<can::RejectedFrames>& all) const;

  can::AxisWire wire;
  Axis axis;
  SensorLink sensor;
  AmplifierLink amplifier;
  StatusSender status_sender;
  std::optional<SetpointReceiver> setpoint_receiver;  ///< Empty: the axis takes no live setpoint.
  std::optional<ScanMarkerSender> scan_marker_sender;
  std::uint64_t heard_in = 0;  ///< the last cycle whose sample came before the deadline of its command
  bool stepped = true;         ///< This cycle's step has been taken.
  bool answered = true;        ///< And its command has gone out, with those of the axes in its frame.
  CyclePhases phases{};        ///< of this cycle's step

 private:
  std::optional<ForeignFrame> foreign_frame_;    ///< for the log
  std::optional<double> fault_that_named_it_s_;  ///< the time of the fault in which the log has named one
  bool sensor_has_the_turn_ = false;             ///< to report an event
};

/// The axes of a controller; their addresses do not change.
using WiredAxes = std::vector<std::unique_ptr<WiredAxis>>;

}  // namespace hystcan::controller
