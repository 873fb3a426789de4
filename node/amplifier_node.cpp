#include "node/amplifier_node.h"

#include <algorithm>
#include <utility>

#include "node/amplifier_channel.h"

namespace hystcan::node {
AmplifierNode::AmplifierNode(const can::AxisWire& first, const CommonConfig& common,
                             const can::Database& database, can::Scheduler& scheduler,
                             const can::Attach& attach)
    : AmplifierNode(*can::find_layout<can::AmpCommand>(database, first), first.amplifier_node, common,
                    scheduler, attach) {}

AmplifierNode::AmplifierNode(const can::Layout<can::AmpCommand>& command, std::uint8_t number,
                             const CommonConfig& common, can::Scheduler& scheduler, const can::Attach& attach)
    : BusNode(number, common, scheduler, attach,
              can::Filter{.id = command.id(), .extended = command.extended()}),
      scheduler_(scheduler),
      cycle_(common.cycle),
      command_id_(command.id()),
      checker_(command.checker()) {
  line().on_frame([this](const can::Frame& frame, can::Time received) {
    if (frame.id == command_id_)
      on_command(frame, received);
    else if (frame.id != can::sync_id)
      handle(frame);
    else if (const auto counter = can::parse_sync(frame))
      on_sync(*counter, received);
  });
}

void AmplifierNode::add(AmplifierChannel& channel) {
  channels_.push_back(&channel);
  if (!channel.status_) return;
  for (StatusMessage& message : statuses_) {
    const can::Layout<can::AmpStatus>& status = *message.channels.front()->status_;
    if (status.id() == channel.status_->id() && status.extended() == channel.status_->extended())
      return message.channels.push_back(&channel);
  }
  statuses_.push_back({can::E2eProtector(channel.status_->protection()), {&channel}});
}

void AmplifierNode::shut_down() {
  for (AmplifierChannel* channel : channels_) channel->enter(can::AmpState::off);
  report();
  for (AmplifierChannel* channel : channels_) {
    // The simulation of a simulated output advances by one second. In this time the output moves to the safe
    // value, so the last status reports the safe value.
    channel->output_.output(scheduler_.now() + std::chrono::seconds(1));  // the output has settled by then
    channel->status_is_due_ = true;
  }
  report();
}

void AmplifierNode::lose_power() {
  for (AmplifierChannel* channel : channels_) channel->enter(can::AmpState::off);
  report();
}

void AmplifierNode::on_command(const can::Frame& frame, can::Time received) {
  if (checker_.check(frame) || state() != can::NmtState::operational) return;
  for (AmplifierChannel* channel : channels_) channel->on_command(channel->command_.decode(frame), received);
  report();
}

void AmplifierNode::on_sync(std::uint8_t counter, can::Time received) {
  const bool follows = last_sync_ != 0 && counter == can::next_sync_counter(last_sync_);
  if (counter != last_sync_) former_sync_at_ = follows ? std::optional(last_sync_at_) : std::nullopt;
  last_sync_at_ = received;
  last_sync_ = counter;
  for (AmplifierChannel* channel : channels_) channel->on_sync(received);
  report();
  const bool may_report = take_slot(counter);
  if (state() != can::NmtState::operational) return;
  for (AmplifierChannel* channel : channels_) ++channel->syncs_since_status_;
  if (may_report) report_regularly();
}

void AmplifierNode::report_regularly() {
  const auto age = [](const AmplifierChannel* one) { return one->syncs_since_status_; };
  const auto note = [](AmplifierChannel* one) {
    one->status_is_due_ |= one->syncs_since_status_ >= one->config_.status_every;
  };
  if (has_slot())
    note(*std::ranges::max_element(channels_, {}, age));
  else
    std::ranges::for_each(channels_, note);
  report();
}

void AmplifierNode::on_nmt(can::NmtState state) {
  if (state == can::NmtState::boot_up) return boot_up();
  checker_.restart();
  for (AmplifierChannel* channel : channels_) channel->on_nmt(state);
  report();
}

// Resets the node when it boots up. The node sends no AmpStatus at this time. Immediately afterwards the node
// becomes pre-operational, and its outputs move to the safe value.
void AmplifierNode::boot_up() {
  last_sync_ = 0;
  for (StatusMessage& message : statuses_) message.protector.restart();
  for (AmplifierChannel* channel : channels_) channel->boot_up();
}

bool AmplifierNode::is_stale(const can::AmpCommand& command, can::Time received) const {
  if (last_sync_ == 0 || !can::is_sync_counter(command.sync_counter)) return true;
  const int syncs_since = can::syncs_after(command.sync_counter, last_sync_);
  if (syncs_since > 1) return true;
  if (!command.enable && !command.clear_fault)
    return false;  // this command only switches off, so its age does not matter
  const std::optional<can::Time> named_at = syncs_since == 0 ? last_sync_at_ : former_sync_at_;
  return !named_at || received - *named_at > 2 * cycle_;
}

// Checks the watchdogs of all axes together, because all of them trip at the same time when commands stop:
// the node then sends one emergency for all axes.
void AmplifierNode::check_watchdogs() {
  for (AmplifierChannel* channel : channels_) channel->check_watchdog();
  report();
}

// Checks the relays of all axes together. If one command frame enables several axes, their relays close at
// the same time. If these axes share a status, the node then sends only one status.
void AmplifierNode::check_relays() {
  for (AmplifierChannel* channel : channels_) channel->check_relay();
  report();
}

void AmplifierNode::note_emergency(std::uint16_t code) {
  if (std::ranges::find(emergencies_, code) == emergencies_.end()) emergencies_.push_back(code);
}

void AmplifierNode::report() {
  const bool is_faulted = std::ranges::any_of(channels_, [](const auto* one) { return one->fault_ != 0; });
  for (const std::uint16_t code : emergencies_)
    line().send(can::emergency_frame(
        number(), {.code = code, .error_register = is_faulted ? std::uint8_t{0x01} : std::uint8_t{0}}));
  emergencies_.clear();
  const auto is_due = [](const AmplifierChannel* one) { return one->status_is_due_; };
  for (StatusMessage& message : statuses_)
    if (std::ranges::any_of(message.channels, is_due))
      for (AmplifierChannel* channel : message.channels) channel->status_is_due_ = true;
  for (AmplifierChannel* channel : channels_)
    if (channel->status_is_due_) channel->syncs_since_status_ = 0;
  for (StatusMessage& message : statuses_)
    if (is_due(message.channels.front())) send(message);
  for (AmplifierChannel* channel : channels_) channel->status_is_due_ = false;
}

void AmplifierNode::send(StatusMessage& message) {
  can::Frame frame = message.channels.front()->status_->frame();
  bool fits = true;
  for (AmplifierChannel* channel : message.channels) {
    fits = channel->status_->put({.output = channel->output_.output(scheduler_.now()),
                                  .state = channel->state_,
                                  .fault = std::min(channel->fault_, channel->largest_fault_)},
                                 frame) &&
           fits;
  }
  if (!fits || !is_on_the_bus()) return;
  message.protector.seal(frame);
  line().send(frame);
}

}  // namespace hystcan::node
