#include "controller/remote_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "can/protocol/emergency.h"

namespace hystcan::controller {

bool is_all_clear(const NodeEvent& event) {
  constexpr std::uint16_t error_group = 0xFF00;
  return event.kind == NodeEvent::Kind::emergency && (event.emergency.code & error_group) == 0;
}

std::string describe(const NodeEvent& event) {
  if (event.kind == NodeEvent::Kind::not_set_up)
    return fmt::format("node {}: not set up: {}", event.node, can::describe(event.failure));
  const can::Emergency& emergency = event.emergency;
  std::string text =
      fmt::format("node {}: emergency 0x{:04X}: {} (error register 0x{:02X}", event.node, emergency.code,
                  can::emergency_text(emergency.code), emergency.error_register);
  if (emergency.manufacturer != decltype(emergency.manufacturer){})
    text += fmt::format(", manufacturer {:02X}", fmt::join(emergency.manufacturer, " "));
  return text + ")";
}

RemoteNode::RemoteNode(std::uint8_t node, can::Duration heartbeat_timeout, const can::SdoSetup::Config& setup)
    : node_(node), heartbeat_(heartbeat_timeout), setup_(node, setup) {}

bool RemoteNode::hear_heartbeat(const can::Frame& frame, can::Time now) {
  if (heartbeat_checker_.check(frame)) return false;
  const auto state = can::parse_heartbeat(frame);
  if (state) heartbeat_.heard(*state, now);
  if (state != can::NmtState::boot_up) return false;
  setup_.restart();
  failure_told_ = false;
  return true;
}

void RemoteNode::hear_emergency(const can::Frame& frame) {
  if (emergency_checker_.check(frame)) return;
  const auto emergency = can::parse_emergency(frame);
  if (!emergency) return;
  const NodeEvent event{.kind = NodeEvent::Kind::emergency, .node = node_, .emergency = *emergency};
  alarm_ |= !is_all_clear(event);
  note(event);
}

void RemoteNode::hear_sdo(const can::Frame& frame) {
  if (!sdo_checker_.check(frame)) setup_.handle(frame);
}

void RemoteNode::forget() {
  heartbeat_.forget();
  setup_.restart();
  failure_told_ = false;
}

void RemoteNode::retry_setup() {
  if (!setup_.has_failed()) return;
  setup_.restart();
  failure_told_ = false;
}

std::optional<can::Frame> RemoteNode::poll_setup(can::Time now) {
  const auto is = state(now);
  if (!is || *is == can::NmtState::stopped) return std::nullopt;  // a stopped node answers no SDO
  const auto request = setup_.poll(now);
  if (setup_.has_failed() && !std::exchange(failure_told_, true))
    note({.kind = NodeEvent::Kind::not_set_up, .node = node_, .failure = setup_.failure()});
  return request;
}

std::optional<NodeEvent> RemoteNode::take_event() {
  if (event_count_ == 0) return std::nullopt;
  const NodeEvent oldest = events_.front();
  std::shift_left(events_.begin(), events_.end(), 1);
  --event_count_;
  return oldest;
}

void RemoteNode::note(const NodeEvent& event) {
  event_count_ = std::min(event_count_ + 1, events_.size());
  events_[event_count_ - 1] = event;
}

}  // namespace hystcan::controller
