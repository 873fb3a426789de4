// What the controller hears, from the identifier to the handler.
#include <algorithm>
#include <cmath>
#include <utility>

#include "controller/controller.h"

namespace hystcan::controller {
namespace {

/// Of the drive's range: an amplifier that goes less from one status to the next rests.
constexpr double at_rest_within = 0.01;

}  // namespace

void Controller::lay_route(std::uint32_t id, bool extended, decltype(Route::handler) handler,
                           std::size_t index) {
  routes_.push_back({.id = id, .extended = extended, .handler = handler, .index = index});
}

template <RemoteNode Controller::WiredAxis::*node>
void Controller::add_node_routes(std::size_t index, decltype(Route::handler) on_heartbeat) {
  const std::uint32_t number = (axes_[index].get()->*node).node();
  lay_route(can::heartbeat_base + number, false, on_heartbeat, index);
  lay_route(can::emergency_base + number, false, &Controller::on_emergency<node>, index);
  lay_route(can::sdo_response_base + number, false, &Controller::on_sdo<node>, index);
}

void Controller::lay_routes() {
  lay_route(can::sync_id, false, &Controller::on_foreign_sync, 0);
  lay_route(can::heartbeat_base + config_.node, false, &Controller::on_own_heartbeat, 0);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const WiredAxis& wired = *axes_[i];
    lay_route(wired.decode_sample.id(), wired.decode_sample.extended(), &Controller::on_sample, i);
    if (wired.decode_status)
      lay_route(wired.decode_status->id(), wired.decode_status->extended(), &Controller::on_status, i);
    lay_route(wired.encode_command.id(), wired.encode_command.extended(), &Controller::on_foreign_command, i);
    if (const auto id = wired.status_sender.id())
      lay_route(*id, false, &Controller::on_foreign_axis_status, i);
    if (wired.setpoint_receiver) lay_route(wired.setpoint_receiver->id(), false, &Controller::on_setpoint, i);
    add_node_routes<&WiredAxis::sensor>(i, &Controller::on_sensor_heartbeat);
    add_node_routes<&WiredAxis::amplifier>(i, &Controller::on_amplifier_heartbeat);
  }
  std::ranges::sort(routes_, {}, &Route::key);
}

/// A frame of the other identifier type in the place of a message goes to that message, which rejects and
/// counts it.
const Controller::Route* Controller::find_route(const can::Frame& frame) const {
  for (const bool extended : {frame.extended, !frame.extended}) {
    const auto key = std::pair(frame.id, extended);
    const auto found = std::ranges::lower_bound(routes_, key, {}, &Route::key);
    if (found != routes_.end() && found->key() == key) return &*found;
  }
  return nullptr;
}

void Controller::handle(const can::Frame& frame) {
  if (const Route* route = find_route(frame)) (this->*route->handler)(route->index, frame);
}

/// Our own frames never come back to us: one that bears our identifier is somebody else's.
void Controller::hear_another() {
  if (phase_ != Phase::listening && phase_ != Phase::running) return;
  for (const auto& wired : axes_)
    if (wired->axis.state() != AxisState::offline)
      wired->axis.trip(Cause::another_controller, can::seconds(scheduler_.now() - started_));
  if (phase_ == Phase::listening) keep_silent();
}

/// The other one may be driving: not even a safe command of ours may come between. What is left to do is to
/// tell.
void Controller::keep_silent() {
  phase_ = Phase::silent;
  sync_timer_->cancel();
  sync_sent_ = scheduler_.now();
  for (std::size_t i = 0; i < axes_.size(); ++i) step(i, nullptr);
}

void Controller::on_own_heartbeat(std::size_t, const can::Frame& frame) {
  if (can::is_heartbeat_of(config_.node, frame)) hear_another();
}

void Controller::on_foreign_sync(std::size_t, const can::Frame& frame) {
  if (can::parse_sync(frame)) hear_another();
}

/// A damaged one, which the amplifier does not take either, is nobody's.
void Controller::on_foreign_command(std::size_t index, const can::Frame& frame) {
  if (!axes_[index]->foreign_command.check(frame)) hear_another();
}

void Controller::on_foreign_axis_status(std::size_t index, const can::Frame& frame) {
  if (axes_[index]->status_sender.is_sound(frame)) hear_another();
}

void Controller::on_setpoint(std::size_t index, const can::Frame& frame) {
  axes_[index]->setpoint_receiver->hear(frame, axes_[index]->axis);
}

void Controller::on_bus_state(can::BusState state) {
  if (state != can::BusState::bus_off && state != can::BusState::down) return;
  for (const auto& wired : axes_) {
    wired->bus_off_seen |= state == can::BusState::bus_off;
    wired->sensor.forget();
    wired->amplifier.forget();
    wired->decode_sample.restart();
    if (wired->decode_status) wired->decode_status->restart();
    wired->status = {};
  }
}

void Controller::on_sample(std::size_t index, const can::Frame& frame) {
  WiredAxis& wired = *axes_[index];
  const auto sample = wired.decode_sample(frame);
  if (!sample) return;
  const bool of_another_cycle = wired.samples_name_their_sync && sample->sync_counter != sync_counter_;
  if (of_another_cycle || wired.answered) {
    ++counters_.late_samples;
    wired.late_sample = true;
    return;
  }
  step(index, &*sample);
  run_background_tasks();
}

void Controller::on_status(std::size_t index, const can::Frame& frame) {
  WiredAxis& wired = *axes_[index];
  const auto status = (*wired.decode_status)(frame);
  if (!status) return;
  wired.amplifier_moves = tells_of_a_move(wired, *status);
  wired.status = *status;
  if (wired.flags_tell_fault && status->fault != 0) wired.status.state = can::AmpState::fault;
}

/// As it is switched off it still tells the drive that it leaves.
bool Controller::tells_of_a_move(const WiredAxis& wired, const can::AmpStatus& status) {
  const bool was_enabled = wired.status.state == can::AmpState::enabled;
  if (was_enabled && status.state != can::AmpState::enabled) return true;
  const Gate::Config& gate = wired.axis.config().gate;
  return std::abs(status.output - wired.status.output) > at_rest_within * (gate.drive_max - gate.drive_min);
}

void Controller::on_sensor_heartbeat(std::size_t index, const can::Frame& frame) {
  WiredAxis& wired = *axes_[index];
  if (wired.sensor.hear_heartbeat(frame, scheduler_.now())) wired.decode_sample.restart();
}

void Controller::on_amplifier_heartbeat(std::size_t index, const can::Frame& frame) {
  WiredAxis& wired = *axes_[index];
  const bool booted = wired.amplifier.hear_heartbeat(frame, scheduler_.now());
  if (booted && wired.decode_status) wired.decode_status->restart();
}

}  // namespace hystcan::controller
