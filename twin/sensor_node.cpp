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

SensorNode::SensorNode(const WiredAxisConfig& config, const CommonConfig& common,
                       const can::Database& database, can::Scheduler& scheduler,
                       std::unique_ptr<can::Bus> bus, Plant& plant)
    : scheduler_(scheduler),
      bus_(std::move(bus)),
      plant_(plant),
      sensor_(config.axis.sensor, common.seed + config.wire.sensor_node, scheduler.now(),
              config.axis.plant.substep),
      runs_free_(config.axis.sample_clock.sampling == Sampling::free),
      period_ns_(1e9 / (config.axis.sample_clock.rate_Hz * (1.0 + 1e-6 * config.axis.sample_clock.skew_ppm))),
      clock_(scheduler.make_timer([this] { on_clock(); })),
      nmt_(*bus_, scheduler, config.wire.sensor_node, common.heartbeat_period,
           [this](can::NmtState state) { on_nmt(state); }),
      sdo_(config.wire.sensor_node),
      encode_sample_(*can::find_layout<can::SensorSample>(database, config.wire)),
      encode_sample_at_power_on_(encode_sample_) {
  if (runs_free_ && !(period_ns_ >= 1.0 && period_ns_ < 1e12))
    throw std::invalid_argument("the sensor samples at " + std::to_string(config.axis.sample_clock.rate_Hz) +
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
