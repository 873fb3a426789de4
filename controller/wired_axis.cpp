#include "controller/wired_axis.h"

#include <initializer_list>
#include <stdexcept>
#include <string>
#include <utility>

namespace hystcan::controller {
namespace {

template <class Payload>
can::Layout<Payload> layout_of(const can::Database& database, const can::AxisWire& wire, const char* what) {
  if (auto layout = can::find_layout<Payload>(database, wire)) return std::move(*layout);
  throw std::invalid_argument("the CAN database has no message " + wire.message_prefix +
                              std::string(Payload::name) + ", expected one for the " + what + " of axis " +
                              wire.name);
}

}  // namespace

WiredAxis::WiredAxis(const WiredAxisConfig& config, std::size_t axis_index, can::Duration heartbeat_timeout,
                     const can::Database& database, SharedFrames& frames)
    : wire(config.wire),
      index(axis_index),
      axis(config.axis),
      sensor(wire, axis_index, heartbeat_timeout, database, frames),
      amplifier(wire, axis, axis_index, heartbeat_timeout, database, frames),
      status_sender(database, wire) {
  if (config.live_setpoint)
    setpoint_receiver.emplace(layout_of<can::Setpoint>(database, wire, "live setpoints"));
  if (config.scan_marker)
    scan_marker_sender.emplace(layout_of<can::ScanMarker>(database, wire, "scan markers"));
}

void WiredAxis::on_another_controller(const ForeignFrame& frame, double time_s) {
  if (axis.state() == AxisState::offline) return;
  axis.trip(Cause::another_controller, time_s);  // on a faulted axis, this ends the ramp
  if (std::exchange(fault_that_named_it_s_, axis.fault().time_s) != axis.fault().time_s)
    foreign_frame_ = frame;
}

std::optional<NodeEvent> WiredAxis::take_event() {
  if (const auto frame = std::exchange(foreign_frame_, std::nullopt))
    return NodeEvent{.kind = NodeEvent::Kind::another_controller, .frame = *frame};
  // The nodes take turns, so that a node with emergencies in every cycle does not hide the events of the
  // other node.
  for (int tries = 0; tries < 2; ++tries) {
    RemoteNode* node = nodes()[sensor_has_the_turn_ ? 0 : 1];
    sensor_has_the_turn_ = !sensor_has_the_turn_;
    if (auto event = node->take_event()) return event;
  }
  return std::nullopt;
}

void WiredAxis::append_rejected(std::vector<can::RejectedFrames>& all, std::set<std::uint8_t>& nodes) const {
  const auto append_first = [&](const ReceivedFrame& frame) {
    if (frame.axes().front() == index) all.push_back(frame.rejected());
  };
  append_first(sensor.samples());
  if (amplifier.statuses() != nullptr) append_first(*amplifier.statuses());
  if (setpoint_receiver)
    all.push_back(
        can::rejected_frames(can::message_map<can::Setpoint>(wire)->message, setpoint_receiver->checker()));
  for (const RemoteNode* node : std::initializer_list<const RemoteNode*>{&amplifier, &sensor}) {
    if (!nodes.insert(node->node()).second) continue;
    const std::string number = std::to_string(node->node());
    all.push_back(can::rejected_frames("heartbeat of node " + number, node->heartbeat_checker()));
    all.push_back(can::rejected_frames("emergency of node " + number, node->emergency_checker()));
    all.push_back(can::rejected_frames("SDO response of node " + number, node->sdo_checker()));
  }
}

}  // namespace hystcan::controller
