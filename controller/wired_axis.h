// One axis and its connection to the bus: the axis itself, the links to its two nodes, and the frames of the
// axis.
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
  bool live_setpoint = false;  ///< The axis obeys Setpoint frames from any sender.
  bool scan_marker = false;    ///< A ScanMarker is sent for each line of a scan.
};

struct WiredAxis {
  /// Throws std::invalid_argument if the database lacks a message or if the model is not valid.
  WiredAxis(const WiredAxisConfig& config, std::size_t axis_index, can::Duration heartbeat_timeout,
            const can::Database& database, SharedFrames& frames);
  WiredAxis(const WiredAxis&) = delete;
  WiredAxis& operator=(const WiredAxis&) = delete;
  ~WiredAxis() = default;

  std::array<RemoteNode*, 2> nodes() { return {&sensor, &amplifier}; }
  /// Called when a frame of another controller arrives. Faults the axis, unless it is offline; if the axis
  /// has already faulted, ends its ramp. The frame is logged once per fault.
  void on_another_controller(const ForeignFrame& frame, double time_s);
  /// Returns the next event for the log, or `nullopt`. A frame of another controller is first. Then the
  /// oldest events of amplifier and sensor follow alternately.
  std::optional<NodeEvent> take_event();
  /// Appends to `all` the numbers of rejected frames of every message that this axis receives. Skips a frame
  /// that an earlier axis has counted, and the nodes in `nodes`, which are counted already. Adds its own
  /// nodes to `nodes`.
  void append_rejected(std::vector<can::RejectedFrames>& all, std::set<std::uint8_t>& nodes) const;

  can::AxisWire wire;
  std::size_t index;  ///< Index of the axis in the controller.
  Axis axis;
  SensorLink sensor;
  AmplifierLink amplifier;
  StatusSender status_sender;
  std::optional<SetpointReceiver> setpoint_receiver;  ///< Empty: the axis does not accept live setpoints.
  std::optional<ScanMarkerSender> scan_marker_sender;
  CyclePhases phases{};  ///< times of the axis's step in this cycle

 private:
  std::optional<ForeignFrame> foreign_frame_;    ///< frame of another controller, for the log
  std::optional<double> fault_that_named_it_s_;  ///< time of the last fault for which foreign_frame_ was set
  bool sensor_has_the_turn_ = false;  ///< true: the sensor reports the next event, otherwise the amplifier
};

/// The axes of a controller; their addresses do not change.
using WiredAxes = std::vector<std::unique_ptr<WiredAxis>>;

}  // namespace hystcan::controller
