#include "node/sensor_node.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "node/sensor_channel.h"

namespace hystcan::node {

SensorNode::SensorNode(const can::AxisWire& first, const SampleClock& clock, const CommonConfig& common,
                       const can::Database& database, can::Scheduler& scheduler, const can::Attach& attach)
    : BusNode(first.sensor_node, common, scheduler, attach),
      scheduler_(scheduler),
      sample_clock_(clock),
      period_ns_(1e9 / (sample_clock_.rate_Hz * (1.0 + 1e-6 * sample_clock_.skew_ppm))),
      clock_(scheduler.make_timer([this] { on_clock(); })),
      protector_(can::find_layout<can::SensorSample>(database, first)->protection()) {
  if (sample_clock_.sampling == Sampling::free && !(period_ns_ >= 1.0 && period_ns_ < 1e12))
    throw std::invalid_argument("the free-running sensor has a sample rate of " +
                                std::to_string(sample_clock_.rate_Hz) + " Hz, expected a rate > 0");
  line().on_frame([this](const can::Frame& frame, can::Time received) {
    if (frame.id != can::sync_id)
      handle(frame);
    else if (const auto counter = can::parse_sync(frame))
      on_sync(*counter, received);
  });
}

void SensorNode::add(SensorChannel& channel, const SampleClock& clock) {
  if (clock != sample_clock_)
    throw std::invalid_argument("the axes of sensor node " + std::to_string(number()) +
                                " have different sample clocks, expected the same clock for all axes");
  channels_.push_back(&channel);
}

void SensorNode::on_nmt(can::NmtState state) {
  if (state == can::NmtState::boot_up) {
    last_sync_ = 0;
    protector_.restart();
  }
  clock_->cancel();
  if (sample_clock_.sampling != Sampling::free || state != can::NmtState::operational) return;
  clock_started_ = scheduler_.now();
  ticks_ = 0;
  on_clock();
}

void SensorNode::on_sync(std::uint8_t counter, can::Time received) {
  const bool is_repeated = std::exchange(last_sync_, counter) == counter;  // the same SYNC was received twice
  if (is_repeated) return;
  if (sample_clock_.sampling == Sampling::sync && state() == can::NmtState::operational) sample(received);
  take_slot(counter);
}

/// Takes a sample at a tick of the sensor's own clock and waits for the next tick in the future. Ticks that
/// passed while this process was not running are skipped.
void SensorNode::on_clock() {
  const can::Time now = scheduler_.now();
  if (last_sync_ != 0) sample(now);
  can::Time next = now;
  while (next <= now)
    next = clock_started_ + can::Duration(std::llround(static_cast<double>(++ticks_) * period_ns_));
  clock_->expire_at(next);
}

void SensorNode::sample(can::Time time) {
  can::Frame frame = channels_.front()->layout_.frame();
  bool fits = true;
  for (SensorChannel* channel : channels_) fits = channel->sample(time, last_sync_, frame) && fits;
  // A sample that the message cannot represent is not sent. Without a sample, the controller reports a
  // fault of the axis.
  if (fits) {
    protector_.seal(frame);
    line().send(frame);
  }
  report_failures();
  for (SensorChannel* channel : channels_)
    if (channel->on_sample_) channel->on_sample_(time, channel->sample_);
}

void SensorNode::report_failures() {
  const bool fails = std::ranges::any_of(channels_, &SensorChannel::has_failed);
  if (std::exchange(has_failed_, fails) == fails) return;
  constexpr std::uint16_t hardware_fails = 0x5000;  // CiA 301: error of the device hardware
  line().send(
      can::emergency_frame(number(), {.code = fails ? hardware_fails : std::uint16_t{0},
                                      .error_register = fails ? std::uint8_t{0x01} : std::uint8_t{0}}));
}

}  // namespace hystcan::node
