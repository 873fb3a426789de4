// What the controller does once a cycle beside its axes: requests, axis statuses, set-up and start of nodes.
#include <algorithm>
#include <utility>

#include "controller/controller.h"

namespace hystcan::controller {
namespace {

std::string_view refusal_of(LiveSetpoint became) {
  switch (became) {
    case LiveSetpoint::taken:
      return {};
    case LiveSetpoint::not_tracking:
      return "the axis does not track a reference";
    case LiveSetpoint::out_of_range:
      break;
  }
  return "the position is outside position_min_um..position_max_um, or of what the model reaches";
}

}  // namespace

/// What has time, once a cycle: when the commands of all axes in use have been sent. The queue to the bus is
/// first in, first out, and short: what is put into it earlier holds the commands up, and what does not fit
/// is lost, so that beside the heartbeat there is one frame at most. Axis statuses and the set-up of nodes
/// take turns, nodes first where a heartbeat is due; a status goes before it, the least urgent frame of all.
void Controller::run_background_tasks() {
  if (house_kept_) return;
  // From the back: samples come in the order of the axes, mostly, so that one look is enough before the last.
  const bool commands_sent = std::all_of(axes_.rbegin(), axes_.rend(), [](const auto& wired) {
    return wired->answered || !is_in_use(wired->axis.state());
  });
  if (!commands_sent) return;
  house_kept_ = true;
  answer_a_request();
  const bool beats = sync_sent_ >= next_heartbeat_;
  if (beats)
    for (const auto& wired : axes_) wired->status_sender.make_due();
  const bool wakes = beats && std::ranges::any_of(axes_, [](const auto& wired) {
                       return wired->axis.state() == AxisState::waiting;
                     });
  bool told = !told_last_cycle_ && !wakes && tell_of_an_axis();
  if (beats) {
    next_heartbeat_ = sync_sent_ + config_.heartbeat_period;
    bus_->send(can::heartbeat_frame(config_.node, can::NmtState::operational));
    if (next_to_wake_ >= node_count()) next_to_wake_ = 0;
  }
  if (!told && !set_up_a_node() && !wake_a_node()) told = tell_of_an_axis();
  told_last_cycle_ = told;
}

/// The next status that is due, of the axes in turn.
bool Controller::tell_of_an_axis() {
  for (std::size_t tried = 0; tried < axes_.size(); ++tried) {
    WiredAxis& wired = *axes_[next_to_tell_of_];
    next_to_tell_of_ = (next_to_tell_of_ + 1) % axes_.size();
    if (wired.status_sender.is_due(wired.axis)) return wired.status_sender.send(wired.axis, *bus_);
  }
  return false;
}

void Controller::answer_a_request() {
  if (requests_ == nullptr) return;
  Request* request = requests_->next();
  if (request == nullptr) return;
  request->refused_because = obey(*request);
  request->cycle = counters_.cycles;
  requests_->answer(request);
}

/// Why not; empty where it is done.
std::string_view Controller::obey(Request& request) {
  if (request.axis >= axes_.size()) return "there is no such axis";
  WiredAxis& wired = *axes_[request.axis];
  Axis& axis = wired.axis;
  switch (request.kind) {
    case Request::Kind::enable:
      if (axis.state() == AxisState::faulted) return "the axis is faulted: clear the fault first";
      if (axis.state() != AxisState::offline) return "the axis is enabled already";
      axis.start(false);
      return {};
    case Request::Kind::disable:
      if (axis.state() == AxisState::faulted || axis.state() == AxisState::offline)
        return "the axis is not enabled";
      axis.stop();
      return {};
    case Request::Kind::clear:
      if (!axis.clear()) return "there is no fault to clear";
      wired.sensor.retry_setup();
      wired.amplifier.retry_setup();
      return {};
    case Request::Kind::go_to:
      return refusal_of(axis.go_to(request.position_um));
    case Request::Kind::resume:
      return refusal_of(axis.resume());
    case Request::Kind::retune:
      return axis.retune(*request.tuning);
    case Request::Kind::revert:
      axis.revert_correction();
      return {};
    case Request::Kind::stop:
      request_stop();
      asked_to_stop_ = true;
      return {};
  }
  return "not a request";
}

/// Both nodes of each axis, sensors at the even places.
RemoteNode& Controller::node_at(std::size_t place) {
  WiredAxis& wired = *axes_[place / 2];
  return place % 2 == 0 ? wired.sensor : wired.amplifier;
}

/// The next SDO request there is, of the nodes in turn; a node that cannot be set up is a fault of its axis.
bool Controller::set_up_a_node() {
  for (std::size_t tried = 0; tried < node_count(); ++tried) {
    const std::size_t place = next_to_set_up_;
    next_to_set_up_ = (place + 1) % node_count();
    Axis& axis = axes_[place / 2]->axis;
    if (axis.state() != AxisState::waiting) continue;
    RemoteNode& node = node_at(place);
    const auto request = node.poll_setup(scheduler_.now());
    if (node.setup_has_failed()) axis.trip(Cause::node_not_set_up, can::seconds(sync_sent_ - started_));
    if (!request) continue;
    bus_->send(*request);
    return true;
  }
  return false;
}

/// Nodes that wait in pre-operational are started once they are set up: each once in a period of the
/// heartbeat.
bool Controller::wake_a_node() {
  while (next_to_wake_ < node_count()) {
    const std::size_t place = next_to_wake_++;
    if (axes_[place / 2]->axis.state() == AxisState::waiting && wake(node_at(place))) return true;
  }
  return false;
}

bool Controller::wake(const RemoteNode& node) {
  const auto state = node.state(scheduler_.now());
  if (node.is_set_up() && state != can::NmtState::operational)
    return bus_->send(can::nmt_frame({can::NmtCommand::start, node.node()}));
  if (!node.is_set_up() && state == can::NmtState::stopped)
    return bus_->send(can::nmt_frame({can::NmtCommand::enter_pre_operational, node.node()}));
  return false;
}

}  // namespace hystcan::controller
