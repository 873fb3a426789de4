#include "twin/sensor_node.h"

#include <utility>

namespace hystcan::twin {

SensorNode::SensorNode(const Config& config, const can::Database& database, can::Scheduler& scheduler,
                       std::unique_ptr<can::Bus> bus, Plant& plant, const Sensor& sensor)
    : bus_(std::move(bus)),
      plant_(plant),
      sensor_(sensor),
      nmt_(*bus_, scheduler, config.wire.sensor_node, config.heartbeat_period,
           [this](can::NmtState state) {
             if (state == can::NmtState::boot_up) forget_everything();
           }),
      sdo_(config.wire.sensor_node),
      encode_sample_(*can::find_layout<can::SensorSample>(database, config.wire)),
      encode_sample_at_power_on_(encode_sample_) {
  bus_->on_frame([this](const can::Frame& frame, can::Time received) { handle(frame, received); });
}

void SensorNode::handle(const can::Frame& frame, can::Time received) {
  if (frame.id == can::sync_id) {
    const auto counter = can::parse_sync(frame);
    if (counter && nmt_.state() == can::NmtState::operational) sample(*counter, received);
  } else {
    nmt_.handle(frame);
    if (nmt_.is_silent() || nmt_.state() == can::NmtState::stopped) return;
    if (const auto response = sdo_.answer(frame)) bus_->send(*response);
  }
}

// As at power-on.
void SensorNode::forget_everything() {
  sdo_.reset();
  encode_sample_ = encode_sample_at_power_on_;
}

void SensorNode::restart() {
  if (is_on_the_bus()) nmt_.start();
}

void SensorNode::sample(std::uint8_t sync_counter, can::Time received) {
  plant_.advance_to(received);
  const double measured_um = sensor_.measure(plant_.position_um());
  // A position beyond what the message can carry is not sent: silence is what the controller trips on.
  if (const auto frame = encode_sample_({.position_um = measured_um, .sync_counter = sync_counter}))
    bus_->send(*frame);
}

}  // namespace hystcan::twin
