#include "controller/background_frames.h"

#include <algorithm>

namespace hystcan::controller {

void BackgroundFrames::start(can::Bus& bus, can::Time now) {
  state_.next_heartbeat = now + config_.heartbeat_period;
  bus.send(can::heartbeat_frame(config_.node, can::NmtState::boot_up));
}

/// Axis statuses and the start-up of nodes take turns. Where a heartbeat is due and an axis waits for its
/// nodes, the nodes come first. A status goes before the heartbeat, which is the least urgent frame of all. A scan
/// marker is the most urgent one: it takes the turn of a status.
void BackgroundFrames::send_next(can::Bus& bus, can::Time sync_sent, can::Time now, double time_s) {
  const bool heartbeat_due = sync_sent >= state_.next_heartbeat;
  if (heartbeat_due)
    for (const auto& wired : axes_) wired->status_sender.make_due();
  const bool nodes_first = heartbeat_due && std::ranges::any_of(axes_, [](const auto& wired) {
                             return wired->axis.state() == AxisState::waiting;
                           });
  bool sent_status =
      send_next_scan_marker(bus) || (!state_.sent_status && !nodes_first && send_next_axis_status(bus));
  if (heartbeat_due) {
    state_.next_heartbeat = sync_sent + config_.heartbeat_period;
    bus.send(can::heartbeat_frame(config_.node, can::NmtState::operational));
    start_up_.begin_period();
  }
  if (!sent_status && !start_up_.send_next(bus, now, time_s)) sent_status = send_next_axis_status(bus);
  state_.sent_status = sent_status;
}

bool BackgroundFrames::send_next_scan_marker(can::Bus& bus) {
  for (const auto& wired : axes_)
    if (auto& marker = wired->scan_marker_sender; marker && marker->is_due()) return marker->send(bus);
  return false;
}

/// The next status that is due; the axes take turns.
bool BackgroundFrames::send_next_axis_status(can::Bus& bus) {
  for (std::size_t tried = 0; tried < axes_.size(); ++tried) {
    WiredAxis& wired = *axes_[state_.next_status];
    state_.next_status = (state_.next_status + 1) % axes_.size();
    if (wired.status_sender.is_due(wired.axis)) return wired.status_sender.send(wired.axis, bus);
  }
  return false;
}

}  // namespace hystcan::controller
