#include "controller/remote_node.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "can/protocol/node.h"

namespace hystcan::controller {

bool is_all_clear(const NodeEvent& event) {
  constexpr std::uint16_t error_group = 0xFF00;
  return event.kind == NodeEvent::Kind::emergency && (event.emergency.code & error_group) == 0;
}

bool are_of_one_kind(const NodeEvent& one, const NodeEvent& other) {
  return one.kind == other.kind && one.node == other.node && one.emergency.code == other.emergency.code &&
         one.command == other.command && one.object == other.object && one.frame == other.frame;
}

namespace {

std::string describe(const can::Emergency& emergency) {
  std::string text = fmt::format("emergency 0x{:04X}: {} (error register 0x{:02X}", emergency.code,
                                 can::emergency_text(emergency.code), emergency.error_register);
  if (emergency.manufacturer != decltype(emergency.manufacturer){})
    text += fmt::format(", manufacturer {:02X}", fmt::join(emergency.manufacturer, " "));
  return text + ")";
}

std::string describe(const ForeignFrame& frame) {
  const std::string id = fmt::format("0x{:0{}X}", frame.id, frame.extended ? 8 : 3);
  switch (frame.kind) {
    case ForeignFrame::Kind::sync:
      return fmt::format("SYNC ({})", id);
    case ForeignFrame::Kind::heartbeat:
      return fmt::format("the heartbeat of this controller ({})", id);
    case ForeignFrame::Kind::command:
      return fmt::format("a command to an amplifier ({})", id);
    case ForeignFrame::Kind::axis_status:
      return fmt::format("a controller's status of an axis ({})", id);
  }
  return {};
}

std::string what_happened(const NodeEvent& event) {
  switch (event.kind) {
    case NodeEvent::Kind::emergency:
      return describe(event.emergency);
    case NodeEvent::Kind::not_set_up:
      return "not set up: " + can::describe(event.failure);
    case NodeEvent::Kind::foreign_nmt:
      return fmt::format("another node sent the NMT command {} ({}) to this node",
                         static_cast<unsigned>(event.command), to_string(event.command));
    case NodeEvent::Kind::foreign_sdo:
      return fmt::format("another node wrote to object 0x{:04X}:{:02X} of this node", event.object.index,
                         event.object.subindex);
    case NodeEvent::Kind::no_such_sync:
      return fmt::format(
          "ignored a sample with SyncCounter {}, expected the counter of the last SYNC, 1 to {}",
          event.sync_counter, can::sync_counter_max);
    case NodeEvent::Kind::outside_slot:
      return fmt::format(
          "heartbeats or statuses of this node arrive outside its slot {} of {}, the last frame in slot {}: "
          "set background_slots = {} in the node, as in the controller, otherwise commands may be late",
          event.node % event.slots, event.slots, event.sync_counter % event.slots, event.slots);
    case NodeEvent::Kind::another_controller:
      return "another node sends " + describe(event.frame);
  }
  return {};
}

}  // namespace

std::string describe(const NodeEvent& event) {
  if (event.kind == NodeEvent::Kind::another_controller) return what_happened(event);
  return fmt::format("node {}: {}", event.node, what_happened(event));
}

std::string describe(const ForeignAccess& access) {
  std::vector<std::string> parts;
  const auto add = [&](std::uint64_t count, std::string_view what) {
    if (count != 0) parts.push_back(fmt::format("{} {}{}", count, what, count == 1 ? "" : "s"));
  };
  add(access.nmt, "NMT command");
  add(access.sdo_writes, "SDO write");
  add(access.sdo_reads, "SDO read");
  return parts.empty() ? "" : fmt::format("{} of another node", fmt::join(parts, ", "));
}

RemoteNode::RemoteNode(std::uint8_t node, can::Duration heartbeat_timeout, can::SdoSetup setup)
    : node_(node), heartbeat_(heartbeat_timeout), setup_(std::move(setup)) {}

Heartbeat RemoteNode::on_heartbeat(const can::Frame& frame, can::Time now) {
  if (heartbeat_checker_.check(frame)) return Heartbeat::rejected;
  const auto state = can::parse_heartbeat(frame);
  if (!state) return Heartbeat::rejected;
  const bool is_as_before = heartbeat_.state(now) == state;
  heartbeat_.on_heartbeat(*state, now);
  if (state != can::NmtState::boot_up) return is_as_before ? Heartbeat::as_before : Heartbeat::new_state;
  set_up_again();
  return Heartbeat::boot_up;
}

void RemoteNode::on_emergency(const can::Frame& frame) {
  if (emergency_checker_.check(frame)) return;
  const auto emergency = can::parse_emergency(frame);
  if (!emergency) return;
  const NodeEvent event{.kind = NodeEvent::Kind::emergency, .node = node_, .emergency = *emergency};
  alarm_ |= !is_all_clear(event);
  note(event);
}

void RemoteNode::on_sdo(const can::Frame& frame) {
  if (!setup_.handle(frame)) sdo_checker_.check(frame);
}

bool RemoteNode::on_foreign_nmt(const can::Frame& frame) {
  const auto nmt = can::parse_nmt(frame);
  if (!nmt || (nmt->node != node_ && nmt->node != 0)) return false;
  ++foreign_.nmt;
  note({.kind = NodeEvent::Kind::foreign_nmt, .node = node_, .command = nmt->command});
  switch (nmt->command) {
    case can::NmtCommand::stop:
    case can::NmtCommand::enter_pre_operational:
    case can::NmtCommand::reset_node:
    case can::NmtCommand::reset_communication:
      return true;
    case can::NmtCommand::start:  // no effect: the node is started already
      break;
  }
  return false;  // a node ignores every other command
}

bool RemoteNode::on_foreign_sdo(const can::Frame& frame) {
  const auto access = can::sdo_access_of(frame);
  if (!access) return false;
  if (access->service != can::SdoService::write) {
    ++foreign_.sdo_reads;
    return false;
  }
  ++foreign_.sdo_writes;
  note({.kind = NodeEvent::Kind::foreign_sdo, .node = node_, .object = access->object});
  set_up_again();
  return true;
}

void RemoteNode::note_no_such_sync(std::uint8_t sync_counter) {
  note({.kind = NodeEvent::Kind::no_such_sync, .node = node_, .sync_counter = sync_counter});
}

// The slot of a node is the cycle after certain SYNCs. A frame that arrives one cycle after the slot also
// counts as inside the slot, because the frame may have waited for the bus.
void RemoteNode::note_background_frame(std::uint8_t sync_counter, unsigned slots) {
  constexpr unsigned certain = 3;  // one or two frames may be late because the bus is full
  const auto before = static_cast<std::uint8_t>(sync_counter - 1);
  if (can::is_in_slot(node_, sync_counter, slots) || can::is_in_slot(node_, before, slots)) {
    if (more_outside_ > 0) --more_outside_;
    return;
  }
  ++outside_slot_;
  if (++more_outside_ < certain || !std::exchange(keeps_slot_, false)) return;
  note({.kind = NodeEvent::Kind::outside_slot, .node = node_, .sync_counter = sync_counter, .slots = slots});
}

void RemoteNode::set_up_again() {
  setup_.restart();
  failure_noted_ = false;
}

void RemoteNode::forget() {
  heartbeat_.forget();
  set_up_again();
}

void RemoteNode::retry_setup() {
  if (setup_.has_failed()) set_up_again();
}

std::optional<can::Frame> RemoteNode::poll_setup(can::Time now) {
  const auto is = state(now);
  // A stopped node does not answer SDO requests.
  if (!is || *is == can::NmtState::stopped) return std::nullopt;
  const auto request = setup_.poll(now);
  if (setup_.has_failed() && !std::exchange(failure_noted_, true))
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
  if (event_count_ > 0 && are_of_one_kind(events_[event_count_ - 1], event)) {
    events_[event_count_ - 1].times += event.times;
    return;
  }
  event_count_ = std::min(event_count_ + 1, events_.size());
  events_[event_count_ - 1] = event;
}

}  // namespace hystcan::controller
