#include "controller/wired_axis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace hystcan::controller {
namespace {

/// Share of the drive's range. The amplifier is at rest if its output changes by less from one status to the
/// next.
constexpr double at_rest_within = 0.01;

/// What is assumed of an amplifier that does not report: it rests at its safe value, and it is enabled.
can::AmpStatus assumed_status(const AxisConfig& axis, const std::optional<can::MessageMap>& status) {
  can::AmpStatus assumed;
  if (!status || !status->carries("output")) assumed.output = axis.gate.safe_drive;
  if (!status || !status->carries("state")) assumed.state = can::AmpState::enabled;
  return assumed;
}

template <class Payload>
can::Layout<Payload> layout_of(const can::Database& database, const can::AxisWire& wire, const char* what) {
  if (auto layout = can::find_layout<Payload>(database, wire)) return std::move(*layout);
  throw std::invalid_argument("no message " + wire.message_prefix + std::string(Payload::name) +
                              ", expected one for the " + what + " of axis " + wire.name);
}

}  // namespace

SensorLink::SensorLink(const can::AxisWire& wire, can::Duration heartbeat_timeout,
                       const can::Database& database)
    : RemoteNode(wire.sensor_node, heartbeat_timeout,
                 {wire.sensor_node, wire.sensor_setup, wire.setup_patience}),
      decode_(*can::find_layout<can::SensorSample>(database, wire)),
      names_its_sync_(can::message_map<can::SensorSample>(wire)->carries("sync_counter")) {}

Heartbeat SensorLink::on_heartbeat(const can::Frame& frame, can::Time now) {
  const Heartbeat heartbeat = RemoteNode::on_heartbeat(frame, now);
  if (heartbeat == Heartbeat::boot_up) decode_.restart();
  return heartbeat;
}

std::optional<can::SensorSample> SensorLink::on_sample(const can::Frame& frame, std::uint64_t cycle) {
  constexpr std::uint64_t forgotten_after = can::sync_counter_max / 2;
  const auto sample = decode_(frame);
  is_doubled_ = false;
  if (!sample || !names_its_sync_) return sample;
  if (!can::is_sync_counter(sample->sync_counter)) {
    note_no_such_sync(sample->sync_counter);
    return std::nullopt;
  }
  const NamedSync last = std::exchange(named_syncs_[sample->sync_counter], {cycle, frame});
  is_doubled_ = last.cycle != 0 && cycle - last.cycle < forgotten_after && !(last.frame == frame);
  return sample;
}

void SensorLink::on_bus_loss() {
  forget();
  decode_.restart();
}

void SensorLink::take_health(can::Time now, AxisInput& input) {
  NodeHealth& health = input.health;
  health.sensor_alive = state(now).has_value();
  health.sensor_operational = is_operational(now);
  health.restarted |= take_restart();
  health.emergency |= take_alarm();
  input.late_sample = std::exchange(late_sample_, false);
}

AmplifierLink::AmplifierLink(const can::AxisWire& wire, const Axis& axis, can::Duration heartbeat_timeout,
                             const can::Database& database, CommandFrame& commands, std::size_t place)
    : RemoteNode(wire.amplifier_node, heartbeat_timeout,
                 {wire.amplifier_node, wire.amplifier_setup, wire.setup_patience}),
      axis_(axis),
      commands_(commands),
      place_(place) {
  const auto map = can::message_map<can::AmpStatus>(wire);
  const can::AmpStatus assumed = assumed_status(axis.config(), map);
  if (auto layout = can::find_layout<can::AmpStatus>(database, wire, assumed))
    decode_.emplace(std::move(*layout));
  else
    status_at_first_ = status_ = assumed;
  reports_output_ = decode_ && map->carries("output");
  flags_report_fault_ = map && (!map->carries("state") || map->states.fault.empty());
}

Heartbeat AmplifierLink::on_heartbeat(const can::Frame& frame, can::Time now) {
  const Heartbeat heartbeat = RemoteNode::on_heartbeat(frame, now);
  if (heartbeat == Heartbeat::boot_up) forget_status();
  return heartbeat;
}

bool AmplifierLink::on_status(const can::Frame& frame, can::Time now) {
  const auto received = (*decode_)(frame);
  if (!received) return false;
  const can::AmpState before = status_.state;
  status_heard_ = now;
  moves_ = std::exchange(is_first_status_, false) || reports_a_move(*received);
  status_ = *received;
  if (flags_report_fault_ && received->fault != 0) status_.state = can::AmpState::fault;
  fault_seen_ |= status_.state == can::AmpState::fault;
  not_enabled_seen_ |= status_.state != can::AmpState::enabled;
  return status_.state == before && before != can::AmpState::off;
}

/// The first status after it is switched off still reports the drive from which the amplifier ramps down.
bool AmplifierLink::reports_a_move(const can::AmpStatus& next) const {
  const bool was_enabled = status_.state == can::AmpState::enabled;
  if (was_enabled && next.state != can::AmpState::enabled) return true;
  const Gate::Config& gate = axis_.config().gate;
  return std::abs(next.output - status_.output) > at_rest_within * (gate.drive_max - gate.drive_min);
}

void AmplifierLink::forget_status() {
  if (decode_) decode_->restart();
  status_ = status_at_first_;
  is_first_status_ = true;
}

void AmplifierLink::on_bus_loss(can::BusState state) {
  bus_off_seen_ |= state == can::BusState::bus_off;
  interface_down_seen_ |= state == can::BusState::down;
  commands_.forget();
  forget();
  forget_status();
}

bool AmplifierLink::put(const std::optional<AxisCommand>& command, std::uint8_t sync_counter) {
  moves_ |= command && command->enable && decode_.has_value();
  return commands_.put(place_, command, sync_counter);
}

double AmplifierLink::output_age_s(can::Time at) const {
  if (!decode_ || is_first_status_) return std::numeric_limits<double>::quiet_NaN();
  return std::max(0.0, can::seconds(at - status_heard_));
}

void AmplifierLink::take_health(can::Time now, can::BusState bus, AxisInput& input) {
  NodeHealth& health = input.health;
  health.interface_up = !std::exchange(interface_down_seen_, false) && bus != can::BusState::down;
  health.bus_on = !std::exchange(bus_off_seen_, false) && bus != can::BusState::bus_off;
  health.bus_passive = bus == can::BusState::passive;
  health.commands_late = commands_.is_late();
  health.amplifier_alive = state(now).has_value();
  health.amplifier_operational = is_operational(now);
  health.restarted |= take_restart();
  health.emergency |= take_alarm();
  const bool is_enabled = status_.state == can::AmpState::enabled;
  health.amplifier_enabled = !std::exchange(not_enabled_seen_, false) && is_enabled;
  health.amplifier_fault = std::exchange(fault_seen_, false) || status_.state == can::AmpState::fault;
  health.amplifier_output = status_.output;
  health.output_reported = reports_output_;
  health.amplifier_moves = moves_;
  health.status_age_s = decode_ ? can::seconds(now - status_heard_) : 0.0;
  health.amplifier_ready = (is_enabled || status_.state == can::AmpState::ready) &&
                           !is_status_too_old(health, axis_.config().supervision.status_timeout);
}

WiredAxis::WiredAxis(const WiredAxisConfig& config, can::Duration heartbeat_timeout,
                     const can::Database& database, CommandFrame& commands, std::size_t place)
    : wire(config.wire),
      axis(config.axis),
      sensor(wire, heartbeat_timeout, database),
      amplifier(wire, axis, heartbeat_timeout, database, commands, place),
      status_sender(database, wire) {
  if (config.live_setpoint)
    setpoint_receiver.emplace(layout_of<can::Setpoint>(database, wire, "live setpoints"));
  if (config.scan_marker)
    scan_marker_sender.emplace(layout_of<can::ScanMarker>(database, wire, "scan markers"));
}

void WiredAxis::on_another_controller(const ForeignFrame& frame, double time_s) {
  if (axis.state() == AxisState::offline) return;
  axis.trip(Cause::another_controller, time_s);  // of a faulted axis it ends the ramp
  if (std::exchange(fault_that_named_it_s_, axis.fault().time_s) != axis.fault().time_s)
    foreign_frame_ = frame;
}

std::optional<NodeEvent> WiredAxis::take_event() {
  if (const auto frame = std::exchange(foreign_frame_, std::nullopt))
    return NodeEvent{.kind = NodeEvent::Kind::another_controller, .frame = *frame};
  // In turn: one node that sends emergencies in every cycle does not hide those of the other.
  for (int tries = 0; tries < 2; ++tries) {
    RemoteNode* node = nodes()[sensor_has_the_turn_ ? 0 : 1];
    sensor_has_the_turn_ = !sensor_has_the_turn_;
    if (auto event = node->take_event()) return event;
  }
  return std::nullopt;
}

void WiredAxis::append_rejected(std::vector<can::RejectedFrames>& all) const {
  const auto append = [&](std::string message, const can::E2eChecker& checker) {
    all.push_back(can::rejected_frames(std::move(message), checker));
  };
  append(can::message_map<can::SensorSample>(wire)->message, sensor.decoder().checker());
  if (const auto& decode = amplifier.decoder())
    append(can::message_map<can::AmpStatus>(wire)->message, decode->checker());
  if (setpoint_receiver) append(can::message_map<can::Setpoint>(wire)->message, setpoint_receiver->checker());
  const auto append_node = [&](const RemoteNode& node) {
    const std::string number = std::to_string(node.node());
    append("heartbeat of node " + number, node.heartbeat_checker());
    append("emergency of node " + number, node.emergency_checker());
    append("SDO response of node " + number, node.sdo_checker());
  };
  append_node(amplifier);
  append_node(sensor);
}

}  // namespace hystcan::controller
