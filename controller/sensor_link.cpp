#include "controller/sensor_link.h"

#include <utility>

namespace hystcan::controller {

SensorLink::SensorLink(const can::AxisWire& wire, std::size_t index, can::Duration heartbeat_timeout,
                       const can::Database& database, SharedFrames& frames)
    : RemoteNode(wire.sensor_node, heartbeat_timeout,
                 {wire.sensor_node, wire.sensor_setup, wire.setup_patience}),
      layout_(*can::find_layout<can::SensorSample>(database, wire)),
      samples_(make_frame(frames.samples, layout_, can::message_map<can::SensorSample>(wire)->message)) {
  const can::MessageMap map = *can::message_map<can::SensorSample>(wire);
  samples_.add(index);
  if (map.carries("sync_counter")) sync_place_ = samples_.add_sync_counter(map.signals.at("sync_counter"));
}

Heartbeat SensorLink::on_heartbeat(const can::Frame& frame, can::Time now) {
  const Heartbeat heartbeat = RemoteNode::on_heartbeat(frame, now);
  if (heartbeat == Heartbeat::boot_up) samples_.restart();
  return heartbeat;
}

std::optional<can::SensorSample> SensorLink::on_sample(const can::Frame& frame, std::uint64_t cycle) {
  const can::SensorSample sample = layout_.decode(frame);
  is_doubled_ = false;
  if (!sync_place_) return sample;
  if (!can::is_sync_counter(sample.sync_counter)) {
    note_no_such_sync(sample.sync_counter);
    return std::nullopt;
  }
  is_doubled_ = samples_.is_doubled(*sync_place_, sample.sync_counter, frame, cycle);
  return sample;
}

void SensorLink::on_bus_loss() {
  forget();
  samples_.restart();
}

void SensorLink::take_health(can::Time now, AxisInput& input) {
  NodeHealth& health = input.health;
  health.sensor_alive = state(now).has_value();
  health.sensor_operational = is_operational(now);
  health.restarted |= take_restart();
  health.emergency |= take_alarm();
  input.late_sample = std::exchange(late_sample_, false);
}

}  // namespace hystcan::controller
