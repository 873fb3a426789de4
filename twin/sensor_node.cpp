#include "twin/sensor_node.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "twin/config.h"

namespace hystcan::twin {
namespace {

/// The points within the delay, one before them and one after them, which does not exist yet.
std::size_t points_needed(can::Duration delay, can::Duration substep) {
  return static_cast<std::size_t>(delay / substep) + 3;
}

}  // namespace

Sensor::Sensor(const Config& config, std::uint64_t seed, can::Time start, can::Duration substep)
    : config_(config),
      start_(start),
      substep_(substep),
      omega_(2.0 * std::numbers::pi * config.bandwidth_Hz),
      substep_decay_(std::exp(-omega_ * can::seconds(substep))),
      points_(points_needed(config.delay, substep)),
      normal_(normal_numbers(seed)),
      density_rms_um_(config.noise_density_um_per_rtHz *
                      std::sqrt(0.5 * std::numbers::pi * config.bandwidth_Hz)) {}

void Sensor::follow(can::Time time, double position_um) {
  const Point next = low_passed(time, position_um);
  newest_ = (newest_ + 1) % points_.size();
  points_[newest_] = next;
  known_ = std::min(known_ + 1, points_.size());
}

Sensor::Reading Sensor::measure(can::Time time, double position_um) {
  const double seen_um = follows() ? delayed_um(low_passed(time, position_um)) : position_um;
  const double lo = config_.range_min_um;
  const double hi = config_.range_max_um;
  const double held_um = std::clamp(seen_um, lo, hi);
  double reading_um = held_um + 0.01 * config_.gain_error_percent * held_um + config_.offset_um +
                      config_.drift_um_per_h * can::seconds(time - start_) / 3600.0;
  if (config_.nonlinearity_percent != 0.0)
    reading_um += 0.01 * config_.nonlinearity_percent * (hi - lo) *
                  std::sin(2.0 * std::numbers::pi * (held_um - lo) / (hi - lo));
  reading_um += config_.noise_um_rms * normal_();
  if (density_rms_um_ > 0.0) reading_um += low_passed_noise(time);
  if (config_.resolution_um > 0.0)
    reading_um = config_.resolution_um * std::round(reading_um / config_.resolution_um);
  return {reading_um, held_um == seen_um};
}

/// u is the lag of a steady ramp:
///   y = x - u + (y_0 - x_0 + u) e^{-omega dt},   u = (x - x_0) / (omega dt)
Sensor::Point Sensor::low_passed(can::Time time, double position_um) const {
  if (config_.bandwidth_Hz == 0.0 || known_ == 0) return {time, position_um, position_um};
  const Point& last = point(0);
  if (time <= last.time) return last;
  const double dt_s = can::seconds(time - last.time);
  const double decay = time - last.time == substep_ ? substep_decay_ : std::exp(-omega_ * dt_s);
  const double lag_um = (position_um - last.position_um) / (omega_ * dt_s);
  return {time, position_um, position_um - lag_um + (last.seen_um - last.position_um + lag_um) * decay};
}

/// Interpolates between the known points and `now`.
double Sensor::delayed_um(const Point& now) const {
  const can::Time then = now.time - config_.delay;
  if (known_ == 0 || then >= now.time) return now.seen_um;
  std::size_t younger = 0;  // bisection for the youngest point that is not after `then`
  std::size_t older = known_;
  while (younger < older) {
    const std::size_t middle = (younger + older) / 2;
    if (point(middle).time <= then)
      older = middle;
    else
      younger = middle + 1;
  }
  if (younger == known_) return point(known_ - 1).seen_um;  // at rest before the oldest known point
  const Point& before = point(younger);
  const Point& after = younger == 0 ? now : point(younger - 1);
  if (after.time == before.time) return before.seen_um;
  const double share = can::seconds(then - before.time) / can::seconds(after.time - before.time);
  return before.seen_um + share * (after.seen_um - before.seen_um);
}

double Sensor::low_passed_noise(can::Time time) {
  const double rho =
      has_sampled_ ? std::exp(-omega_ * can::seconds(std::max(time, last_sample_) - last_sample_)) : 0.0;
  density_noise_um_ = rho * density_noise_um_ + std::sqrt(1.0 - rho * rho) * density_rms_um_ * normal_();
  last_sample_ = time;
  has_sampled_ = true;
  return density_noise_um_;
}

/// Age 0 is the newest point.
const Sensor::Point& Sensor::point(std::size_t age) const {
  return points_[(newest_ + points_.size() - age) % points_.size()];
}

SensorNode::SensorNode(const WiredAxisConfig& first, const CommonConfig& common,
                       const can::Database& database, can::Scheduler& scheduler, const can::Attach& attach)
    : BusNode(first.wire.sensor_node, common, scheduler, attach),
      scheduler_(scheduler),
      sample_clock_(first.axis.sample_clock),
      period_ns_(1e9 / (sample_clock_.rate_Hz * (1.0 + 1e-6 * sample_clock_.skew_ppm))),
      clock_(scheduler.make_timer([this] { on_clock(); })),
      protector_(can::find_layout<can::SensorSample>(database, first.wire)->protection()) {
  if (sample_clock_.sampling == Sampling::free && !(period_ns_ >= 1.0 && period_ns_ < 1e12))
    throw std::invalid_argument("the sensor samples at " + std::to_string(sample_clock_.rate_Hz) +
                                " Hz by its own clock, expected a rate > 0");
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
                                " sample by different clocks, expected one for all of them");
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
  const bool is_repeated = std::exchange(last_sync_, counter) == counter;  // the same SYNC, received twice
  if (is_repeated) return;
  if (sample_clock_.sampling == Sampling::sync && state() == can::NmtState::operational) sample(received);
  take_slot(counter);
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
  can::Frame frame = channels_.front()->layout_.frame();
  bool fits = true;
  for (SensorChannel* channel : channels_) channel->plant_.advance_to(time);
  for (SensorChannel* channel : channels_) fits = channel->sample(time, last_sync_, frame) && fits;
  // A position that the message cannot carry is not sent: the controller trips on the missing sample.
  if (fits) {
    protector_.seal(frame);
    line().send(frame);
  }
  for (SensorChannel* channel : channels_)
    if (channel->on_sample_) channel->on_sample_(time, channel->sample_);
}

SensorChannel::SensorChannel(const WiredAxisConfig& config, const CommonConfig& common,
                             const can::Database& database, can::Time start, SensorNode& node, Plant& plant)
    : node_(node),
      index_(node.channels_.size()),
      plant_(plant),
      sensor_(config.axis.sensor, seed_of(common.seed, config.wire.sensor_node, index_), start,
              config.axis.plant.substep),
      layout_(*can::find_layout<can::SensorSample>(database, config.wire)) {
  node_.line().add_channel(sent_by(Node::sensor, database, config.wire));
  node_.add(*this, config.axis.sample_clock);
}

bool SensorChannel::sample(can::Time time, std::uint8_t sync_counter, can::Frame& frame) {
  const Sensor::Reading reading = sensor_.measure(time, plant_.position_um());
  sample_ = {.position_um = reading.position_um,
             .sync_counter = sync_counter,
             .status = reading.in_range ? std::uint8_t{0} : sensor_status::out_of_range};
  return layout_.put(sample_, frame);
}

}  // namespace hystcan::twin
