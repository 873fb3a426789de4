// One axis with its place on the bus: the axis itself, the codecs of its frames, and what is known of its two
// nodes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/dbc/database.h"
#include "can/protocol/protocol.h"
#include "controller/control/axis.h"
#include "controller/own_frames.h"
#include "controller/pending_commands.h"
#include "controller/remote_node.h"

namespace hystcan::controller {

struct WiredAxisConfig {
  can::AxisWire wire;
  AxisConfig axis;
  bool live_setpoint = false;  ///< The axis obeys Setpoint frames, whoever sends them.
  bool scan_marker = false;    ///< A ScanMarker is sent for each line of a scan.
};

struct WiredAxis {
  /// Throws std::invalid_argument where the database lacks a message or the model is not valid.
  WiredAxis(const WiredAxisConfig& config, can::Duration heartbeat_timeout, const can::Database& database);

  void handle_status(const can::Frame& frame, can::Time now);
  void handle_sensor_heartbeat(const can::Frame& frame, can::Time now);
  void handle_amplifier_heartbeat(const can::Frame& frame, can::Time now);
  /// The bus is off or the interface is down: what is known of the nodes may no longer hold.
  void handle_bus_loss(can::BusState state);

  /// False: the sample names a SYNC that there is not. It answers no cycle; the log says so.
  bool names_a_possible_sync(const can::SensorSample& sample);
  /// True: this sample and another one, both accepted, name the same SYNC. A frame that is sent twice is no other one.
  bool names_a_sync_again(const can::Frame& frame, const can::SensorSample& sample, std::uint64_t cycle);

  /// What is known of both nodes for the next step. Each event since the last step counts once.
  NodeHealth take_health(can::Time now, can::BusState bus);
  /// Faults the axis, unless it is offline; ends the ramp of a faulted one. The log names the frame, once in a fault.
  void meet_another_controller(const ForeignFrame& frame, double time_s);
  /// The oldest event not yet taken, of amplifier and sensor in turn; first the frame of another controller.
  std::optional<NodeEvent> take_event();
  /// Of every message of this axis that the controller receives.
  void append_rejected(std::vector<can::RejectedFrames>& all) const;

  can::AxisWire wire;
  Axis axis;
  can::Decoder<can::SensorSample> decode_sample;
  std::optional<can::Decoder<can::AmpStatus>> decode_status;  ///< Empty: the amplifier sends no status.
  can::Encoder<can::AmpCommand> encode_command;
  bool samples_name_their_sync;     ///< If false, a sample counts for the cycle in which it arrives.
  bool flags_report_fault;          ///< The state field alone does not report a fault.
  can::E2eChecker foreign_command;  ///< Checks commands to this amplifier that another node sends.
  StatusSender status_sender;
  std::optional<SetpointReceiver> setpoint_receiver;  ///< Empty: the axis takes no live setpoint.
  std::optional<ScanMarkerSender> scan_marker_sender;
  RemoteNode sensor;
  RemoteNode amplifier;

  PendingCommands pending_commands;

  // What is remembered from one frame or step to the next.
  can::AmpStatus status;  ///< The last one received.
  can::Time status_heard{};
  bool amplifier_moves = false;  ///< Enabled, or ramping down: `status` does not say where the output is.
  unsigned boot_ups_seen = 0;
  bool late_sample = false;           ///< A sample of another cycle came since the last step.
  bool amplifier_fault_seen = false;  ///< A status said fault since the last step, however briefly.
  bool not_enabled_seen = false;      ///< A status said another state than enabled since the last step.
  bool bus_off_seen = false;          ///< The bus was off since the last step, however briefly.
  bool interface_down_seen = false;   ///< The interface was down since the last step, however briefly.
  bool answered = true;               ///< This cycle's step has been taken.
  bool sensor_has_the_turn = false;   ///< To report an event.

 private:
  void forget_status();
  bool reports_a_move(const can::AmpStatus& next) const;

  struct NamedSync {
    std::uint64_t cycle = 0;  ///< 0: none yet
    can::Frame frame{};
  };
  std::optional<ForeignFrame> foreign_frame_;    ///< for the log
  std::optional<double> fault_that_named_it_s_;  ///< the time of the fault in which the log has named one
  std::array<NamedSync, 256> named_syncs_{};     ///< by SyncCounter: the last sample that named it
  can::AmpStatus status_at_first_;  ///< What holds before a status comes, or where none ever comes.
};

/// The axes of a controller; their addresses do not change.
using WiredAxes = std::vector<std::unique_ptr<WiredAxis>>;

}  // namespace hystcan::controller
