#include "twin/sensor_node.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace hystcan::twin {

SensorNode::SensorNode(const Config& config, const can::Database& database, can::Scheduler& scheduler,
                       std::unique_ptr<can::Bus> bus, Plant& plant, Sensor sensor)
    : scheduler_(scheduler),
      bus_(std::move(bus)),
      plant_(plant),
      sensor_(std::move(sensor)),
      runs_free_(config.clock.sampling == Sampling::free),
      period_ns_(1e9 / (config.clock.rate_Hz * (1.0 + 1e-6 * config.clock.skew_ppm))),
      clock_(scheduler.make_timer([this] { on_clock(); })),
      nmt_(*bus_, scheduler, config.wire.sensor_node, config.heartbeat_period,
           [this](can::NmtState state) { on_nmt(state); }),
      sdo_(config.wire.sensor_node),
      encode_sample_(*can::find_layout<can::SensorSample>(database, config.wire)),
      encode_sample_at_power_on_(encode_sample_) {
  if (runs_free_ && !(period_ns_ >= 1.0 && period_ns_ < 1e12))
    throw std::invalid_argument("the sensor samples at " + std::to_string(config.clock.rate_Hz) +
                                " Hz by its own clock, expected a rate > 0");
  bus_->on_frame([this](const can::Frame& frame, can::Time received) { handle(frame, received); });
}

void SensorNode::handle(const can::Frame& frame, can::Time received) {
  if (frame.id == can::sync_id) {
    if (const auto counter = can::parse_sync(frame)) on_sync(*counter, received);
  } else {
    nmt_.handle(frame);
    if (nmt_.is_silent() || nmt_.state() == can::NmtState::stopped) return;
    if (const auto response = sdo_.answer(frame)) bus_->send(*response);
  }
}

void SensorNode::boot_up() {
  last_sync_ = 0;
  encode_sample_ = encode_sample_at_power_on_;
  if (nmt_.last_reset() == can::NmtCommand::reset_node) sdo_.reset();
}

void SensorNode::restart() {
  if (is_on_the_bus()) nmt_.start();
}

void SensorNode::on_nmt(can::NmtState state) {
  if (state == can::NmtState::boot_up) boot_up();
  clock_->cancel();
  if (!runs_free_ || state != can::NmtState::operational) return;
  clock_started_ = scheduler_.now();
  ticks_ = 0;
  on_clock();
}

void SensorNode::on_sync(std::uint8_t counter, can::Time received) {
  const bool is_repeated = std::exchange(last_sync_, counter) == counter;  // the same SYNC, received twice
  if (is_repeated) return;
  if (!runs_free_ && nmt_.state() == can::NmtState::operational) sample(received);
}

/// Skips the ticks that have passed while the computer did not run this process.
void SensorNode::on_clock() {
  const can::Time now = scheduler_.now();
  if (last_sync_ != 0) sample(now);
  can::Time next = now;
  while (next <= now)
    next = clock_started_ + can::Duration(std::llround(static_cast<double>(++ticks_) * period_ns_));
  clock_->expire_at(next);
}

void SensorNode::sample(can::Time time) {
  plant_.advance_to(time);
  const Sensor::Reading reading = sensor_.measure(time, plant_.position_um());
  const can::SensorSample sample{.position_um = reading.position_um,
                                 .sync_counter = last_sync_,
                                 .status = reading.in_range ? std::uint8_t{0} : sensor_status::out_of_range};
  // A position that the message cannot carry is not sent: the controller trips on the missing sample.
  if (const auto frame = encode_sample_(sample)) bus_->send(*frame);
  if (on_sample_) on_sample_(time, sample);
}

}  // namespace hystcan::twin
