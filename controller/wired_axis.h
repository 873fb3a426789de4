// One axis with its place on the bus: the axis itself, and the links to its two nodes with the codecs of
// their frames.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "can/bus.h"
#include "can/dbc/database.h"
#include "can/protocol/protocol.h"
#include "controller/amplifier_link.h"
#include "controller/control/axis.h"
#include "controller/cycle_record.h"
#include "controller/remote_node.h"
#include "controller/scan_marker_sender.h"
#include "controller/sensor_link.h"
#include "controller/setpoint_receiver.h"
#include "controller/shared_frames.h"
#include "controller/status_sender.h"

namespace hystcan::controller {

struct WiredAxisConfig {
  can::AxisWire wire;
  AxisConfig axis;
  bool live_setpoint = false;  ///< The axis obeys Setpoint frames, whoever sends them.
  bool scan_marker = false;    ///< A ScanMarker is sent for each line of a scan.
};

struct WiredAxis {
  /// Throws std::invalid_argument where the database lacks a message or the model is not valid.
  WiredAxis(const WiredAxisConfig& config, std::size_t axis_index, can::Duration heartbeat_timeout,
            const can::Database& database, SharedFrames& frames);
  WiredAxis(const WiredAxis&) = delete;
  WiredAxis& operator=(const WiredAxis&) = delete;
  ~WiredAxis() = default;

  std::array<RemoteNode*, 2> nodes() { return {&sensor, &amplifier}; }
  /// Faults the axis, unless it is offline; ends the ramp of a faulted one. The log names the frame, once in
  /// a fault.
  void on_another_controller(const ForeignFrame& frame, double time_s);
  /// The oldest event not yet taken, of amplifier and sensor in turn; first the frame of another controller.
  std::optional<NodeEvent> take_event();
  /// Of every message of this axis that the controller receives, but for a frame of an axis before it and for
  /// the messages of `nodes`, which are counted already.
  void append_rejected(std::vector<can::RejectedFrames>& all, std::set<std::uint8_t>& nodes) const;

  can::AxisWire wire;
  std::size_t index;  ///< Among the axes of the controller.
  Axis axis;
  SensorLink sensor;
  AmplifierLink amplifier;
  StatusSender status_sender;
  std::optional<SetpointReceiver> setpoint_receiver;  ///< Empty: the axis takes no live setpoint.
  std::optional<ScanMarkerSender> scan_marker_sender;
  CyclePhases phases{};  ///< of this cycle's step

 private:
  std::optional<ForeignFrame> foreign_frame_;    ///< for the log
  std::optional<double> fault_that_named_it_s_;  ///< the time of the fault in which the log has named one
  bool sensor_has_the_turn_ = false;             ///< to report an event
};

/// The axes of a controller; their addresses do not change.
using WiredAxes = std::vector<std::unique_ptr<WiredAxis>>;

}  // namespace hystcan::controller
