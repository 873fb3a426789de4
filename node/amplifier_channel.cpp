#include "node/amplifier_channel.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::node {
namespace {

// CiA 301, table of emergency error codes.
constexpr std::uint16_t emergency_error_reset = 0x0000;
constexpr std::uint16_t emergency_heartbeat = 0x8130;
constexpr std::uint16_t emergency_data_set = 0x6300;
constexpr std::uint16_t emergency_device_hardware = 0x5000;

/// Returns the maximum value of the signal for the fault in the status message of this axis.
std::uint8_t largest_fault(const can::Database& database, const can::AxisWire& wire) {
  constexpr double all_bits = 0xFF;
  const auto map = can::message_map_in<can::AmpStatus>(database, wire);
  if (!map || !map->carries("fault")) return 0xFF;
  const can::Signal& signal =
      can::find_signal(can::find_message(database, *map), map->signals.find("fault")->second);
  return static_cast<std::uint8_t>(std::clamp(can::SignalCodec(signal).maximum(), 0.0, all_bits));
}

}  // namespace

AmplifierChannel::AmplifierChannel(const can::AxisWire& wire, const AmplifierConfig& config,
                                   const CommonConfig& common, const can::Database& database,
                                   can::Scheduler& scheduler, AmplifierNode& node, DriveOutput& output)
    : config_(config),
      interpolation_(config.interpolate ? common.cycle : can::Duration::zero()),
      scheduler_(scheduler),
      node_(node),
      index_(node.channels_.size()),
      output_(output),
      // If the command message has no signal Enable, every command enables the amplifier.
      command_(*can::find_layout<can::AmpCommand>(database, wire, {.enable = true})),
      status_(can::find_layout<can::AmpStatus>(database, wire)),
      largest_fault_(largest_fault(database, wire)),
      commands_name_their_sync_(can::message_map<can::AmpCommand>(wire)->carries("sync_counter")),
      watchdog_(scheduler.make_timer([this] { node_.check_watchdogs(); })),
      relay_(scheduler.make_timer([this] { node_.check_relays(); })) {
  node_.add(*this);
}

void AmplifierChannel::on_sync(can::Time received) {
  watch_output();
  if (state_ == can::AmpState::enabled && config_.apply == Apply::sync)
    output_.go_to(setpoint_, received, interpolation_);
  if (soft_start_begun_) start_softly(received);
}

void AmplifierChannel::on_command(const can::AmpCommand& command, can::Time received) {
  if (commands_name_their_sync_ && node_.is_stale(command, received)) return;
  if (state_ == can::AmpState::fault) {
    if (command.clear_fault && !has_internal_cause_) clear_fault();
    return;
  }
  if (!command.enable) return enter(can::AmpState::ready);
  if (!output_.reaches(command.setpoint))
    return trip(can::amp_fault::setpoint_out_of_range, emergency_data_set);
  setpoint_ = command.setpoint;
  command_deadline_ = scheduler_.now() + config_.command_timeout;
  if (state_ != can::AmpState::enabled) return begin_to_enable();
  if (config_.apply == Apply::receipt) output_.go_to(setpoint_, scheduler_.now());
}

void AmplifierChannel::clear_fault() {
  fault_ = 0;
  node_.note_emergency(emergency_error_reset);
  enter(can::AmpState::ready);
}

void AmplifierChannel::begin_to_enable() {
  if (relay_is_open_ || std::exchange(is_enabling_, true)) return;
  output_.switch_on();
  if (config_.enable_delay == can::Duration::zero()) return connect();
  relay_closes_at_ = scheduler_.now() + config_.enable_delay;
  relay_->expire_at(relay_closes_at_);
}

void AmplifierChannel::check_relay() {
  if (is_enabling_ && !soft_start_begun_ && scheduler_.now() >= relay_closes_at_) connect();
}

void AmplifierChannel::connect() {
  if (config_.soft_start == can::Duration::zero()) return begin_to_drive();
  soft_start_begun_ = scheduler_.now();
  soft_start_from_ = output_.output(scheduler_.now());
}

void AmplifierChannel::start_softly(can::Time now) {
  if (now >= command_deadline_) return leave_drive(WatchdogAction::safe);
  const double share = can::seconds(now - *soft_start_begun_) / can::seconds(config_.soft_start);
  if (share >= 1.0) return begin_to_drive();
  output_.go_to(std::lerp(soft_start_from_, setpoint_, share), now, interpolation_);
}

void AmplifierChannel::begin_to_drive() {
  if (scheduler_.now() >= command_deadline_) return leave_drive(WatchdogAction::safe);
  is_enabling_ = false;
  soft_start_begun_.reset();
  watchdog_->expire_at(command_deadline_);
  enter(can::AmpState::enabled);
  if (config_.apply == Apply::receipt) output_.go_to(setpoint_, scheduler_.now());
}

void AmplifierChannel::on_nmt(can::NmtState state) {
  if (state != can::NmtState::operational) return enter(can::AmpState::off);
  enter(fault_ == 0 ? can::AmpState::ready : can::AmpState::fault);
}

// Resets the amplifier when its node boots up. An internal fault stays if its cause still exists.
void AmplifierChannel::boot_up() {
  state_ = can::AmpState::off;
  syncs_since_status_ = 0;
  if (node_.last_reset() == can::NmtCommand::reset_node) fault_ = has_internal_cause_ ? internal_fault : 0;
}

void AmplifierChannel::begin_internal_fault() {
  has_internal_cause_ = true;
  if (node_.state() != can::NmtState::operational) {
    fault_ |= internal_fault;  // a node that is not operational reports the fault later, after NMT start
    return;
  }
  trip(internal_fault, emergency_device_hardware);
  node_.report();
}

void AmplifierChannel::watch_output() {
  const bool works = output_.works();
  if (std::exchange(output_works_, works) == works) return;
  if (works)
    end_internal_fault();
  else
    begin_internal_fault();
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
  output_.leave(action, scheduler_.now());
}

}  // namespace hystcan::node
