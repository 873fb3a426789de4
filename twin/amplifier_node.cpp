#include "twin/amplifier_node.h"

#include <array>
#include <cmath>
#include <utility>

namespace hystcan::twin {
namespace {

// CiA 301, table of emergency error codes.
constexpr std::uint16_t emergency_error_reset = 0x0000;
constexpr std::uint16_t emergency_heartbeat = 0x8130;
constexpr std::uint16_t emergency_data_set = 0x6300;
constexpr std::uint16_t emergency_device_hardware = 0x5000;

}  // namespace

AmplifierNode::AmplifierNode(const WiredAxisConfig& config, const CommonConfig& common,
                             const can::Database& database, can::Scheduler& scheduler,
                             const can::Attach& attach, Plant& plant)
    : config_(config.axis),
      interpolation_(config.axis.interpolate ? common.cycle : can::Duration::zero()),
      scheduler_(scheduler),
      // Without an Enable signal, a command alone enables the amplifier.
      decode_command_(*can::find_layout<can::AmpCommand>(database, config.wire, {.enable = true})),
      bus_(attach(
          std::array{can::Filter{can::nmt_id}, can::Filter{can::sync_id},
                     can::Filter{can::heartbeat_base + config.wire.amplifier_node},
                     can::Filter{can::sdo_request_base + config.wire.amplifier_node},
                     can::Filter{.id = decode_command_.id(), .extended = decode_command_.extended()}})),
      plant_(plant),
      nmt_(*bus_, scheduler, config.wire.amplifier_node, common.heartbeat_period,
           [this](can::NmtState state) { on_nmt(state); }),
      sdo_(config.wire.amplifier_node),
      node_(config.wire.amplifier_node),
      commands_name_their_sync_(can::message_map<can::AmpCommand>(config.wire)->carries("sync_counter")),
      watchdog_(scheduler.make_timer([this] { check_watchdog(); })),
      relay_(scheduler.make_timer([this] { connect(); })) {
  if (auto layout = can::find_layout<can::AmpStatus>(database, config.wire))
    encode_status_.emplace(std::move(*layout));
  encode_status_at_power_on_ = encode_status_;
  bus_->on_frame([this](const can::Frame& frame, can::Time received) { handle(frame, received); });
}

void AmplifierNode::shut_down() {
  enter(can::AmpState::off);
  plant_.advance_to(scheduler_.now() + std::chrono::seconds(1));
  send_status();
}

void AmplifierNode::handle(const can::Frame& frame, can::Time received) {
  if (frame.id == decode_command_.id()) {
    if (const auto command = decode_command_(frame)) on_command(*command);
  } else if (frame.id == can::sync_id) {
    if (const auto counter = can::parse_sync(frame)) on_sync(*counter, received);
  } else {
    nmt_.handle(frame);
    if (nmt_.is_silent() || nmt_.state() == can::NmtState::stopped) return;
    if (const auto response = sdo_.answer(frame)) bus_->send(*response);
  }
}

void AmplifierNode::on_sync(std::uint8_t counter, can::Time received) {
  last_sync_ = counter;
  if (state_ == can::AmpState::enabled && config_.apply == Apply::sync) {
    plant_.advance_to(received);
    aim_at(setpoint_);
  }
  if (soft_start_begun_) start_softly(received);
  if (nmt_.state() == can::NmtState::operational && ++syncs_since_status_ >= config_.status_every)
    send_status();
}

void AmplifierNode::on_command(const can::AmpCommand& command) {
  if (nmt_.state() != can::NmtState::operational || is_stale(command)) return;
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

bool AmplifierNode::is_stale(const can::AmpCommand& command) const {
  if (!commands_name_their_sync_) return false;
  const int named = command.sync_counter;
  if (last_sync_ == 0 || !can::is_sync_counter(named)) return true;
  return (last_sync_ - named + can::sync_counter_max) % can::sync_counter_max > 1;
}

void AmplifierNode::clear_fault() {
  fault_ = 0;
  bus_->send(can::emergency_frame(node_, {.code = emergency_error_reset}));
  enter(can::AmpState::ready);
}

void AmplifierNode::begin_to_enable() {
  if (std::exchange(is_enabling_, true)) return;
  if (config_.enable_delay == can::Duration::zero()) return connect();
  relay_->expire_at(scheduler_.now() + config_.enable_delay);
}

void AmplifierNode::connect() {
  if (config_.soft_start == can::Duration::zero()) return begin_to_drive();
  plant_.advance_to(scheduler_.now());
  soft_start_begun_ = scheduler_.now();
  soft_start_from_ = plant_.drive();
}

void AmplifierNode::start_softly(can::Time now) {
  if (now >= command_deadline_) return leave_drive(WatchdogAction::safe);
  const double share = can::seconds(now - *soft_start_begun_) / can::seconds(config_.soft_start);
  if (share >= 1.0) return begin_to_drive();
  plant_.advance_to(now);
  aim_at(std::lerp(soft_start_from_, setpoint_, share));
}

void AmplifierNode::begin_to_drive() {
  is_enabling_ = false;
  soft_start_begun_.reset();
  if (scheduler_.now() >= command_deadline_) return;  // the commands have stopped meanwhile
  watchdog_->expire_at(command_deadline_);
  enter(can::AmpState::enabled);
  if (config_.apply == Apply::receipt) take_setpoint();
}

void AmplifierNode::take_setpoint() {
  plant_.advance_to(scheduler_.now());
  plant_.set_target(setpoint_);
}

void AmplifierNode::aim_at(double drive) { plant_.move_target(drive, interpolation_); }

void AmplifierNode::on_nmt(can::NmtState state) {
  if (state == can::NmtState::boot_up) return boot_up();
  if (state != can::NmtState::operational) return enter(can::AmpState::off);
  decode_command_.restart();
  enter(fault_ == 0 ? can::AmpState::ready : can::AmpState::fault);
}

// A node that boots up sends no status; the state pre-operational, which follows, leaves the drive. The cause
// of an internal fault may still exist.
void AmplifierNode::boot_up() {
  state_ = can::AmpState::off;
  encode_status_ = encode_status_at_power_on_;
  last_sync_ = 0;
  syncs_since_status_ = 0;
  if (nmt_.last_reset() == can::NmtCommand::reset_communication) return;
  sdo_.reset();
  fault_ = has_internal_cause_ ? internal_fault : 0;
}

void AmplifierNode::begin_internal_fault() {
  has_internal_cause_ = true;
  if (nmt_.state() == can::NmtState::operational) return trip(internal_fault, emergency_device_hardware);
  fault_ |= internal_fault;  // reported when the node is started
}

void AmplifierNode::restart() {
  if (is_on_the_bus()) nmt_.start();
}

void AmplifierNode::check_watchdog() {
  if (state_ != can::AmpState::enabled) return;
  if (scheduler_.now() < command_deadline_) return watchdog_->expire_at(command_deadline_);
  trip(can::amp_fault::command_timeout, emergency_heartbeat, config_.watchdog_action);
}

void AmplifierNode::trip(std::uint8_t fault, std::uint16_t emergency_code, WatchdogAction action) {
  fault_ |= fault;
  bus_->send(can::emergency_frame(node_, {.code = emergency_code, .error_register = 0x01}));
  enter(can::AmpState::fault, action);
}

void AmplifierNode::enter(can::AmpState state, WatchdogAction action) {
  if (state != can::AmpState::enabled) leave_drive(action);
  if (state == state_) return;
  state_ = state;
  send_status();
}

void AmplifierNode::leave_drive(WatchdogAction action) {
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

void AmplifierNode::send_status() {
  syncs_since_status_ = 0;
  plant_.advance_to(scheduler_.now());
  if (!encode_status_ || nmt_.is_silent()) return;
  if (const auto frame = (*encode_status_)({.output = plant_.drive(), .state = state_, .fault = fault_}))
    bus_->send(*frame);
}

}  // namespace hystcan::twin
