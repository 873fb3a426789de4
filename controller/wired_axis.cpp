#include "controller/wired_axis.h"

#include <cmath>
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

can::E2eChecker checker_of(const can::Layout<can::AmpCommand>& layout) {
  return {layout.protection(), layout.length(), layout.extended()};
}

}  // namespace

WiredAxis::WiredAxis(const WiredAxisConfig& config, can::Duration heartbeat_timeout,
                     const can::Database& database)
    : wire(config.wire),
      axis(config.axis),
      decode_sample(*can::find_layout<can::SensorSample>(database, wire)),
      encode_command(*can::find_layout<can::AmpCommand>(database, wire)),
      samples_name_their_sync(can::message_map<can::SensorSample>(wire)->carries("sync_counter")),
      flags_report_fault(false),
      foreign_command(checker_of(*can::find_layout<can::AmpCommand>(database, wire))),
      status_sender(database, wire),
      sensor(wire.sensor_node, heartbeat_timeout, {wire.sensor_setup, wire.setup_patience}),
      amplifier(wire.amplifier_node, heartbeat_timeout, {wire.amplifier_setup, wire.setup_patience}) {
  const auto map = can::message_map<can::AmpStatus>(wire);
  const can::AmpStatus assumed = assumed_status(config.axis, map);
  if (auto layout = can::find_layout<can::AmpStatus>(database, wire, assumed))
    decode_status.emplace(std::move(*layout));
  else
    status_at_first_ = status = assumed;
  if (config.live_setpoint) setpoint_receiver.emplace(database, wire);
  if (config.scan_marker) scan_marker_sender.emplace(database, wire);
  flags_report_fault = map && (!map->carries("state") || map->states.fault.empty());
}

void WiredAxis::handle_status(const can::Frame& frame, can::Time now) {
  const auto received = (*decode_status)(frame);
  if (!received) return;
  status_heard = now;
  amplifier_moves = reports_a_move(*received);
  status = *received;
  if (flags_report_fault && received->fault != 0) status.state = can::AmpState::fault;
  amplifier_fault_seen |= status.state == can::AmpState::fault;
  not_enabled_seen |= status.state != can::AmpState::enabled;
}

/// The first status after it is switched off still reports the drive from which the amplifier ramps down.
bool WiredAxis::reports_a_move(const can::AmpStatus& next) const {
  const bool was_enabled = status.state == can::AmpState::enabled;
  if (was_enabled && next.state != can::AmpState::enabled) return true;
  const Gate::Config& gate = axis.config().gate;
  return std::abs(next.output - status.output) > at_rest_within * (gate.drive_max - gate.drive_min);
}

void WiredAxis::handle_sensor_heartbeat(const can::Frame& frame, can::Time now) {
  if (sensor.hear_heartbeat(frame, now)) decode_sample.restart();
}

void WiredAxis::handle_amplifier_heartbeat(const can::Frame& frame, can::Time now) {
  if (amplifier.hear_heartbeat(frame, now)) forget_status();
}

void WiredAxis::forget_status() {
  if (decode_status) decode_status->restart();
  status = status_at_first_;
}

void WiredAxis::handle_bus_loss(can::BusState state) {
  bus_off_seen |= state == can::BusState::bus_off;
  pending_commands.forget();
  interface_down_seen |= state == can::BusState::down;
  sensor.forget();
  amplifier.forget();
  decode_sample.restart();
  forget_status();
}

bool WiredAxis::names_a_possible_sync(const can::SensorSample& sample) {
  if (!samples_name_their_sync || can::is_sync_counter(sample.sync_counter)) return true;
  sensor.note_no_such_sync(sample.sync_counter);
  return false;
}

bool WiredAxis::names_a_sync_again(const can::Frame& frame, const can::SensorSample& sample,
                                   std::uint64_t cycle) {
  constexpr std::uint64_t forgotten_after = can::sync_counter_max / 2;
  if (!samples_name_their_sync) return false;
  const NamedSync last = std::exchange(named_syncs_[sample.sync_counter], {cycle, frame});
  return last.cycle != 0 && cycle - last.cycle < forgotten_after && !(last.frame == frame);
}

NodeHealth WiredAxis::take_health(can::Time now, can::BusState bus) {
  const unsigned boot_ups = sensor.boot_ups() + amplifier.boot_ups();
  const bool restarted = std::exchange(boot_ups_seen, boot_ups) != boot_ups;
  const bool sensor_emergency = sensor.take_alarm();
  const bool emergency = amplifier.take_alarm() || sensor_emergency;
  const bool fault_seen = std::exchange(amplifier_fault_seen, false);
  const bool dropped_out = std::exchange(not_enabled_seen, false);
  const bool was_off = std::exchange(bus_off_seen, false);
  const bool was_down = std::exchange(interface_down_seen, false);
  NodeHealth health{
      .interface_up = bus != can::BusState::down && !was_down,
      .bus_on = bus != can::BusState::bus_off && !was_off,
      .bus_passive = bus == can::BusState::passive,
      .commands_late = pending_commands.are_late(),
      .sensor_alive = sensor.state(now).has_value(),
      .sensor_operational = sensor.is_operational(now),
      .amplifier_alive = amplifier.state(now).has_value(),
      .amplifier_operational = amplifier.is_operational(now),
      .restarted = restarted,
      .emergency = emergency,
      .amplifier_ready = status.state == can::AmpState::ready || status.state == can::AmpState::enabled,
      .amplifier_enabled = status.state == can::AmpState::enabled && !dropped_out,
      .amplifier_fault = status.state == can::AmpState::fault || fault_seen,
      .amplifier_output = status.output,
      .output_reported = decode_status.has_value(),
      .amplifier_moves = amplifier_moves,
      .status_age_s = decode_status ? can::seconds(now - status_heard) : 0.0};
  if (is_status_too_old(health, axis.config().supervision.status_timeout)) health.amplifier_ready = false;
  return health;
}

void WiredAxis::meet_another_controller(const ForeignFrame& frame, double time_s) {
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
    RemoteNode& node = sensor_has_the_turn ? sensor : amplifier;
    sensor_has_the_turn = !sensor_has_the_turn;
    if (auto event = node.take_event()) return event;
  }
  return std::nullopt;
}

void WiredAxis::append_rejected(std::vector<can::RejectedFrames>& all) const {
  const auto append = [&](std::string message, const can::E2eChecker& checker) {
    all.push_back(can::rejected_frames(std::move(message), checker));
  };
  append(can::message_map<can::SensorSample>(wire)->message, decode_sample.checker());
  if (decode_status) append(can::message_map<can::AmpStatus>(wire)->message, decode_status->checker());
  if (setpoint_receiver) append(can::message_map<can::Setpoint>(wire)->message, setpoint_receiver->checker());
  for (const RemoteNode* node : {&amplifier, &sensor}) {
    const std::string number = std::to_string(node->node());
    append("heartbeat of node " + number, node->heartbeat_checker());
    append("emergency of node " + number, node->emergency_checker());
    append("SDO response of node " + number, node->sdo_checker());
  }
}

}  // namespace hystcan::controller
