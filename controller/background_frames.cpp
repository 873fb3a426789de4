#include "controller/background_frames.h"

#include <algorithm>

namespace hystcan::controller {
namespace {

bool send_command(const RemoteNode& node, can::Bus& bus, can::Time now) {
  const auto state = node.state(now);
  if (node.is_set_up() && state != can::NmtState::operational)
    return bus.send(can::nmt_frame({can::NmtCommand::start, node.node()}));
  if (!node.is_set_up() && state == can::NmtState::stopped)
    return bus.send(can::nmt_frame({can::NmtCommand::enter_pre_operational, node.node()}));
  return false;
}

}  // namespace

void BackgroundFrames::start(can::Bus& bus, can::Time now) {
  next_heartbeat_ = now + heartbeat_period_;
  bus.send(can::heartbeat_frame(node_, can::NmtState::boot_up));
}

/// Axis statuses and the start-up of nodes take turns. Where a heartbeat is due and an axis waits for its
/// nodes, the nodes come first. A status goes before the heartbeat, which is the least urgent frame of all. A
/// scan marker is the most urgent one: it takes the turn of a status.
void BackgroundFrames::send_next(can::Bus& bus, can::Time sync_sent, can::Time now, double time_s) {
  const bool heartbeat_due = sync_sent >= next_heartbeat_;
  if (heartbeat_due)
    for (const auto& wired : axes_) wired->status_sender.make_due();
  const bool nodes_first = heartbeat_due && std::ranges::any_of(axes_, [](const auto& wired) {
                             return wired->axis.state() == AxisState::waiting;
                           });
  bool sent_status =
      send_next_scan_marker(bus) || (!sent_status_ && !nodes_first && send_next_axis_status(bus));
  if (heartbeat_due) {
    next_heartbeat_ = sync_sent + heartbeat_period_;
    bus.send(can::heartbeat_frame(node_, can::NmtState::operational));
    if (next_to_command_ >= node_count()) next_to_command_ = 0;
  }
  if (!sent_status && !send_next_setup_request(bus, now, time_s) && !send_next_nmt_command(bus, now))
    sent_status = send_next_axis_status(bus);
  sent_status_ = sent_status;
}

bool BackgroundFrames::send_next_scan_marker(can::Bus& bus) {
  for (const auto& wired : axes_)
    if (auto& marker = wired->scan_marker_sender; marker && marker->is_due()) return marker->send(bus);
  return false;
}

/// The next status that is due; the axes take turns.
bool BackgroundFrames::send_next_axis_status(can::Bus& bus) {
  for (std::size_t tried = 0; tried < axes_.size(); ++tried) {
    WiredAxis& wired = *axes_[next_status_];
    next_status_ = (next_status_ + 1) % axes_.size();
    if (wired.status_sender.is_due(wired.axis)) return wired.status_sender.send(wired.axis, bus);
  }
  return false;
}

bool BackgroundFrames::send_next_setup_request(can::Bus& bus, can::Time now, double time_s) {
  for (std::size_t tried = 0; tried < node_count(); ++tried) {
    const std::size_t place = next_to_set_up_;
    next_to_set_up_ = (place + 1) % node_count();
    Axis& axis = axes_[place / 2]->axis;
    if (axis.state() != AxisState::waiting) continue;
    RemoteNode& node = node_at(place);
    const auto request = node.poll_setup(now);
    if (node.setup_has_failed()) axis.trip(Cause::node_not_set_up, time_s);
    if (!request) continue;
    bus.send(*request);
    return true;
  }
  return false;
}

bool BackgroundFrames::send_next_nmt_command(can::Bus& bus, can::Time now) {
  while (next_to_command_ < node_count()) {
    const std::size_t place = next_to_command_++;
    if (axes_[place / 2]->axis.state() == AxisState::waiting && send_command(node_at(place), bus, now))
      return true;
  }
  return false;
}

}  // namespace hystcan::controller
