#include "twin/sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hystcan::twin {
namespace {

/// Returns the required size of the ring buffer of positions. The buffer has one position per sub-step within
/// the delay, one position before them for the interpolation, and one place for the next position.
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

/// Returns the true position x at `time` with the low-passed position y. Solves the low pass
/// y' = omega (x - y) over the time dt since the last stored point (x_0, y_0):
///   y = x - u + (y_0 - x_0 + u) e^{-omega dt},   u = (x - x_0) / (omega dt)
/// omega is the corner frequency of the low pass in 1/s. x moves linearly during dt. u is the distance by
/// which y lags behind x on a steady ramp.
Sensor::Point Sensor::low_passed(can::Time time, double position_um) const {
  if (config_.bandwidth_Hz == 0.0 || known_ == 0) return {time, position_um, position_um};
  const Point& last = point(0);
  if (time <= last.time) return last;
  const double dt_s = can::seconds(time - last.time);
  const double decay = time - last.time == substep_ ? substep_decay_ : std::exp(-omega_ * dt_s);
  const double lag_um = (position_um - last.position_um) / (omega_ * dt_s);
  return {time, position_um, position_um - lag_um + (last.seen_um - last.position_um + lag_um) * decay};
}

/// Returns the low-passed position one delay before `now`, interpolated between the stored points and `now`.
double Sensor::delayed_um(const Point& now) const {
  const can::Time then = now.time - config_.delay;
  if (known_ == 0 || then >= now.time) return now.seen_um;
  std::size_t younger = 0;  // the bisection finds the youngest stored point that is not after `then`
  std::size_t older = known_;
  while (younger < older) {
    const std::size_t middle = (younger + older) / 2;
    if (point(middle).time <= then)
      older = middle;
    else
      younger = middle + 1;
  }
  if (younger == known_) return point(known_ - 1).seen_um;  // the sensor was at rest before its oldest point
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

/// Returns the stored point that is `age` grid points older than the newest one.
const Sensor::Point& Sensor::point(std::size_t age) const {
  return points_[(newest_ + points_.size() - age) % points_.size()];
}

}  // namespace hystcan::twin
