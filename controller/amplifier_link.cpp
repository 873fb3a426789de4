#include "controller/amplifier_link.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hystcan::controller {
namespace {

/// Share of the drive's range. The amplifier is at rest if its output changes by less than this from one
/// status to the next.
constexpr double at_rest_within = 0.01;

/// Returns the values that are assumed for the parts of a status that the amplifier does not send: the output
/// is the safe drive, and the state is enabled.
can::AmpStatus assumed_status(const AxisConfig& axis, const std::optional<can::MessageMap>& status) {
  can::AmpStatus assumed;
  if (!status || !status->carries("output")) assumed.output = axis.gate.safe_drive;
  if (!status || !status->carries("state")) assumed.state = can::AmpState::enabled;
  return assumed;
}

}  // namespace

AmplifierLink::AmplifierLink(const can::AxisWire& wire, const Axis& axis, std::size_t index,
                             can::Duration heartbeat_timeout, const can::Database& database,
                             SharedFrames& frames)
    : RemoteNode(wire.amplifier_node, heartbeat_timeout,
                 {wire.amplifier_node, wire.amplifier_setup, wire.setup_patience}),
      axis_(axis),
      commands_(make_frame(frames.commands, *can::find_layout<can::AmpCommand>(database, wire))),
      place_(commands_.add(*can::find_layout<can::AmpCommand>(database, wire), index,
                           axis.config().gate.safe_drive)) {
  const auto map = can::message_map<can::AmpStatus>(wire);
  const can::AmpStatus assumed = assumed_status(axis.config(), map);
  layout_ = can::find_layout<can::AmpStatus>(database, wire, assumed);
  if (layout_) {
    statuses_ = &make_frame(frames.statuses, *layout_, map->message);
    statuses_->add(index);
  } else {
    status_at_first_ = status_ = assumed;
  }
  reports_output_ = layout_ && map->carries("output");
  flags_report_fault_ = map && (!map->carries("state") || map->states.fault.empty());
}

Heartbeat AmplifierLink::on_heartbeat(const can::Frame& frame, can::Time now) {
  const Heartbeat heartbeat = RemoteNode::on_heartbeat(frame, now);
  if (heartbeat == Heartbeat::boot_up) forget_status();
  return heartbeat;
}

bool AmplifierLink::on_status(const can::Frame& frame, can::Time now) {
  const can::AmpStatus received = layout_->decode(frame);
  const can::AmpState before = status_.state;
  status_heard_ = now;
  moves_ = std::exchange(is_first_status_, false) || reports_a_move(received);
  status_ = received;
  if (flags_report_fault_ && received.fault != 0) status_.state = can::AmpState::fault;
  fault_seen_ |= status_.state == can::AmpState::fault;
  not_enabled_seen_ |= status_.state != can::AmpState::enabled;
  return status_.state == before && before != can::AmpState::off;
}

/// True if the output of the amplifier may still move. After the amplifier is switched off, its first status
/// still reports the drive from which it ramps down.
bool AmplifierLink::reports_a_move(const can::AmpStatus& next) const {
  const bool was_enabled = status_.state == can::AmpState::enabled;
  if (was_enabled && next.state != can::AmpState::enabled) return true;
  const Gate::Config& gate = axis_.config().gate;
  return std::abs(next.output - status_.output) > at_rest_within * (gate.drive_max - gate.drive_min);
}

void AmplifierLink::forget_status() {
  if (statuses_ != nullptr) statuses_->restart();
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
  moves_ |= command && command->enable && layout_.has_value();
  return commands_.put(place_, command, sync_counter);
}

double AmplifierLink::output_age_s(can::Time at) const {
  if (!layout_ || is_first_status_) return std::numeric_limits<double>::quiet_NaN();
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
  health.status_age_s = layout_ ? can::seconds(now - status_heard_) : 0.0;
  health.amplifier_ready = (is_enabled || status_.state == can::AmpState::ready) &&
                           !is_status_too_old(health, axis_.config().supervision.status_timeout);
}

}  // namespace hystcan::controller
