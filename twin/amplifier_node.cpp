#include "twin/amplifier_node.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::twin {
namespace {

// CiA 301, table of emergency error codes.
constexpr std::uint16_t emergency_error_reset = 0x0000;
constexpr std::uint16_t emergency_heartbeat = 0x8130;
constexpr std::uint16_t emergency_data_set = 0x6300;
constexpr std::uint16_t emergency_device_hardware = 0x5000;

/// The largest number that the status of this axis carries as its fault.
std::uint8_t largest_fault(const can::Database& database, const can::AxisWire& wire) {
  constexpr double all_bits = 0xFF;
  const auto map = can::message_map_in<can::AmpStatus>(database, wire);
  if (!map || !map->carries("fault")) return 0xFF;
  const can::Signal& signal =
      can::find_signal(can::find_message(database, *map), map->signals.find("fault")->second);
  return static_cast<std::uint8_t>(std::clamp(can::SignalCodec(signal).maximum(), 0.0, all_bits));
}

}  // namespace

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
    channel->plant_.advance_to(scheduler_.now() + std::chrono::seconds(1));
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

// A node that boots up sends no status; the state pre-operational, which follows, leaves the drive.
void AmplifierNode::boot_up() {
  last_sync_ = 0;
  for (StatusMessage& message : statuses_) message.protector.restart();
  for (AmplifierChannel* channel : channels_) channel->boot_up();
}

bool AmplifierNode::is_stale(const can::AmpCommand& command, can::Time received) const {
  if (last_sync_ == 0 || !can::is_sync_counter(command.sync_counter)) return true;
  const int syncs_since = can::syncs_after(command.sync_counter, last_sync_);
  if (syncs_since > 1) return true;
  if (!command.enable && !command.clear_fault) return false;  // it switches off
  const std::optional<can::Time> named_at = syncs_since == 0 ? last_sync_at_ : former_sync_at_;
  return !named_at || received - *named_at > 2 * cycle_;
}

// Where commands stop, the watchdogs of all axes trip at one time: this is one event.
void AmplifierNode::check_watchdogs() {
  for (AmplifierChannel* channel : channels_) channel->check_watchdog();
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
  for (AmplifierChannel* channel : channels_) {
    if (!channel->status_is_due_) continue;
    channel->syncs_since_status_ = 0;
    channel->plant_.advance_to(scheduler_.now());
  }
  for (StatusMessage& message : statuses_)
    if (is_due(message.channels.front())) send(message);
  for (AmplifierChannel* channel : channels_) channel->status_is_due_ = false;
}

void AmplifierNode::send(StatusMessage& message) {
  can::Frame frame = message.channels.front()->status_->frame();
  bool fits = true;
  for (AmplifierChannel* channel : message.channels) {
    fits = channel->status_->put({.output = channel->plant_.drive(),
                                  .state = channel->state_,
                                  .fault = std::min(channel->fault_, channel->largest_fault_)},
                                 frame) &&
           fits;
  }
  if (!fits || !is_on_the_bus()) return;
  message.protector.seal(frame);
  line().send(frame);
}

AmplifierChannel::AmplifierChannel(const WiredAxisConfig& config, const CommonConfig& common,
                                   const can::Database& database, can::Scheduler& scheduler,
                                   AmplifierNode& node, Plant& plant)
    : config_(config.axis),
      interpolation_(config.axis.interpolate ? common.cycle : can::Duration::zero()),
      scheduler_(scheduler),
      node_(node),
      index_(node.channels_.size()),
      plant_(plant),
      // Without an Enable signal, a command alone enables the amplifier.
      command_(*can::find_layout<can::AmpCommand>(database, config.wire, {.enable = true})),
      status_(can::find_layout<can::AmpStatus>(database, config.wire)),
      largest_fault_(largest_fault(database, config.wire)),
      commands_name_their_sync_(can::message_map<can::AmpCommand>(config.wire)->carries("sync_counter")),
      watchdog_(scheduler.make_timer([this] { node_.check_watchdogs(); })),
      relay_(scheduler.make_timer([this] {
        connect();
        node_.report();
      })) {
  node_.line().add_channel(sent_by(Node::amplifier, database, config.wire));
  node_.add(*this);
}

void AmplifierChannel::on_sync(can::Time received) {
  if (state_ == can::AmpState::enabled && config_.apply == Apply::sync) {
    plant_.advance_to(received);
    aim_at(setpoint_);
  }
  if (soft_start_begun_) start_softly(received);
}

void AmplifierChannel::on_command(const can::AmpCommand& command, can::Time received) {
  if (commands_name_their_sync_ && node_.is_stale(command, received)) return;
  if (state_ == can::AmpState::fault) {
    if (command.clear_fault && !has_internal_cause_) clear_fault();
    return;
  }
  if (!command.enable) return enter(can::AmpState::ready);
  const Amplifier::Config& amplifier = config_.plant.amplifier;
  if (command.setpoint < amplifier.drive_min || command.setpoint > amplifier.drive_max)
    return trip(can::amp_fault::setpoint_out_of_range, emergency_data_set);
  setpoint_ = command.setpoint;
  command_deadline_ = scheduler_.now() + config_.command_timeout;
  if (state_ != can::AmpState::enabled) return begin_to_enable();
  if (config_.apply == Apply::receipt) take_setpoint();
}

void AmplifierChannel::clear_fault() {
  fault_ = 0;
  node_.note_emergency(emergency_error_reset);
  enter(can::AmpState::ready);
}

void AmplifierChannel::begin_to_enable() {
  if (relay_is_open_ || std::exchange(is_enabling_, true)) return;
  if (config_.enable_delay == can::Duration::zero()) return connect();
  relay_->expire_at(scheduler_.now() + config_.enable_delay);
}

void AmplifierChannel::connect() {
  if (config_.soft_start == can::Duration::zero()) return begin_to_drive();
  plant_.advance_to(scheduler_.now());
  soft_start_begun_ = scheduler_.now();
  soft_start_from_ = plant_.drive();
}

void AmplifierChannel::start_softly(can::Time now) {
  if (now >= command_deadline_) return leave_drive(WatchdogAction::safe);
  const double share = can::seconds(now - *soft_start_begun_) / can::seconds(config_.soft_start);
  if (share >= 1.0) return begin_to_drive();
  plant_.advance_to(now);
  aim_at(std::lerp(soft_start_from_, setpoint_, share));
}

void AmplifierChannel::begin_to_drive() {
  is_enabling_ = false;
  soft_start_begun_.reset();
  if (scheduler_.now() >= command_deadline_) return;  // the commands have stopped meanwhile
  watchdog_->expire_at(command_deadline_);
  enter(can::AmpState::enabled);
  if (config_.apply == Apply::receipt) take_setpoint();
}

void AmplifierChannel::take_setpoint() {
  plant_.advance_to(scheduler_.now());
  plant_.set_target(setpoint_);
}

void AmplifierChannel::aim_at(double drive) { plant_.move_target(drive, interpolation_); }

void AmplifierChannel::on_nmt(can::NmtState state) {
  if (state != can::NmtState::operational) return enter(can::AmpState::off);
  enter(fault_ == 0 ? can::AmpState::ready : can::AmpState::fault);
}

// The cause of an internal fault may still exist.
void AmplifierChannel::boot_up() {
  state_ = can::AmpState::off;
  syncs_since_status_ = 0;
  if (node_.last_reset() == can::NmtCommand::reset_node) fault_ = has_internal_cause_ ? internal_fault : 0;
}

void AmplifierChannel::begin_internal_fault() {
  has_internal_cause_ = true;
  if (node_.state() != can::NmtState::operational) {
    fault_ |= internal_fault;  // reported when the node is started
    return;
  }
  trip(internal_fault, emergency_device_hardware);
  node_.report();
}

void AmplifierChannel::open_relay() {
  relay_is_open_ = true;
  if (state_ != can::AmpState::enabled && state_ != can::AmpState::ready) return;
  enter(can::AmpState::ready);
  node_.report();
}

void AmplifierChannel::check_watchdog() {
  if (state_ != can::AmpState::enabled) return;
  if (scheduler_.now() < command_deadline_) return watchdog_->expire_at(command_deadline_);
  trip(can::amp_fault::command_timeout, emergency_heartbeat, config_.watchdog_action);
}

void AmplifierChannel::trip(std::uint8_t fault, std::uint16_t emergency_code, WatchdogAction action) {
  fault_ |= fault;
  node_.note_emergency(emergency_code);
  enter(can::AmpState::fault, action);
}

void AmplifierChannel::enter(can::AmpState state, WatchdogAction action) {
  if (state != can::AmpState::enabled) leave_drive(action);
  if (state == state_) return;
  state_ = state;
  status_is_due_ = true;
}

void AmplifierChannel::leave_drive(WatchdogAction action) {
  is_enabling_ = false;
  soft_start_begun_.reset();
  relay_->cancel();
  plant_.advance_to(scheduler_.now());
  switch (action) {
    case WatchdogAction::safe:
      return plant_.set_target(config_.plant.amplifier.safe_drive);
    case WatchdogAction::hold:
      return;
    case WatchdogAction::ramp:
      return plant_.set_target(config_.plant.amplifier.safe_drive, Amplifier::Course::ramp);
    case WatchdogAction::off:
      return plant_.set_target(0.0, Amplifier::Course::off);
  }
}

}  // namespace hystcan::twin
