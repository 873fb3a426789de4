#include "controller/background_frames.h"

#include <algorithm>

namespace hystcan::controller {
namespace {

bool send_command(const RemoteNode& node, bool is_set_up, can::Bus& bus, can::Time now) {
  const auto state = node.state(now);
  if (is_set_up && state != can::NmtState::operational)
    return bus.send(can::nmt_frame({can::NmtCommand::start, node.node()}));
  if (!is_set_up && state == can::NmtState::stopped)
    return bus.send(can::nmt_frame({can::NmtCommand::enter_pre_operational, node.node()}));
  return false;
}

}  // namespace

bool BackgroundFrames::some_axis_waits() const {
  return std::ranges::any_of(axes_,
                             [](const auto& wired) { return wired->axis.state() == AxisState::waiting; });
}

void BackgroundFrames::for_each_with(std::uint8_t number, auto visit) const {
  for (const auto& wired : axes_)
    for (const RemoteNode* node : wired->nodes())
      if (node->node() == number) visit(wired->axis, *node);
}

void BackgroundFrames::start(can::Bus& bus, can::Time now) {
  next_heartbeat_ = now + heartbeat_period_;
  bus.send(can::heartbeat_frame(node_, can::NmtState::boot_up));
}

/// With slots, sends only a frame of the start-up; begin_cycle() sends the other frames. Without slots, sends
/// a scan marker if one is due; otherwise statuses and frames of the start-up take turns. In a cycle in which
/// a heartbeat is due and an axis waits for its nodes, it is the turn of the start-up. A due heartbeat is
/// sent in addition, after a marker or a status whose turn it is, because the heartbeat is less urgent.
void BackgroundFrames::send_next(can::Bus& bus, can::Time sync_sent, can::Time now, double time_s) {
  is_done_ = true;
  if (slots_ != 0) {
    send_next_of_start_up(bus, now, time_s);
    return;
  }
  const bool heartbeat_due = heartbeat_is_due(sync_sent);
  if (heartbeat_due) make_statuses_due();
  const bool nodes_first = heartbeat_due && some_axis_waits();
  bool sent_status =
      send_next_scan_marker(bus) || (!sent_status_ && !nodes_first && send_next_axis_status(bus));
  if (heartbeat_due) send_heartbeat(bus, sync_sent);
  const bool sent_to_node = !sent_status && send_next_of_start_up(bus, now, time_s);
  if (!sent_status && !sent_to_node) sent_status = send_next_axis_status(bus);
  sent_status_ = sent_status;
}

void BackgroundFrames::begin_cycle(can::Bus& bus, std::uint8_t sync_counter, can::Time sync_sent) {
  is_done_ = false;
  if (slots_ == 0 || !can::is_in_slot(node_, sync_counter, slots_)) return;
  if (heartbeat_is_due(sync_sent)) {
    make_statuses_due();
    return send_heartbeat(bus, sync_sent);
  }
  if (!send_next_scan_marker(bus)) send_next_axis_status(bus);
}

void BackgroundFrames::make_statuses_due() {
  for (const auto& wired : axes_) wired->status_sender.make_due();
}

/// Sends the heartbeat. After each heartbeat, each node may receive one NMT command again. If a heartbeat had
/// to wait for its slot, the later heartbeats are not shifted.
void BackgroundFrames::send_heartbeat(can::Bus& bus, can::Time sync_sent) {
  next_heartbeat_ += heartbeat_period_;
  if (next_heartbeat_ <= sync_sent) next_heartbeat_ = sync_sent + heartbeat_period_;
  bus.send(can::heartbeat_frame(node_, can::NmtState::operational));
  if (next_to_command_ >= node_count()) next_to_command_ = 0;
}

bool BackgroundFrames::send_next_of_start_up(can::Bus& bus, can::Time now, double time_s) {
  return some_axis_waits() && (send_next_setup_request(bus, now, time_s) || send_next_nmt_command(bus, now));
}

bool BackgroundFrames::send_next_scan_marker(can::Bus& bus) {
  for (const auto& wired : axes_)
    if (auto& marker = wired->scan_marker_sender; marker && marker->is_due()) return marker->send(bus);
  return false;
}

/// Sends the next status that is due; the axes take turns.
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
    RemoteNode& node = node_at(place);
    bool is_waited_for = false;
    for_each_with(node.node(), [&](const Axis& axis, const RemoteNode&) {
      is_waited_for |= axis.state() == AxisState::waiting;
    });
    if (!is_waited_for) continue;
    const auto request = node.poll_setup(now);
    if (node.setup_has_failed())
      for_each_with(node.node(), [&](Axis& axis, const RemoteNode&) {
        if (axis.state() == AxisState::waiting) axis.trip(Cause::node_not_set_up, time_s);
      });
    if (!request) continue;
    bus.send(*request);
    return true;
  }
  return false;
}

bool BackgroundFrames::send_next_nmt_command(can::Bus& bus, can::Time now) {
  while (next_to_command_ < node_count()) {
    const std::size_t place = next_to_command_++;
    if (axes_[place / 2]->axis.state() != AxisState::waiting) continue;
    const RemoteNode& node = node_at(place);
    bool is_set_up = true;
    for_each_with(node.node(), [&](const Axis&, const RemoteNode& same) { is_set_up &= same.is_set_up(); });
    if (send_command(node, is_set_up, bus, now)) return true;
  }
  return false;
}

}  // namespace hystcan::controller
