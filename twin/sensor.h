// The physics of the position sensor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "can/scheduler.h"
#include "twin/noise.h"

namespace hystcan::twin {

// The position sensor turns the true position x of the stage into a reading, step by step:
//
//   y' = omega (x - y),  omega = 2 pi bandwidth     exact for a position that is linear between grid points
//   z(t) = y(t - delay)                             linear between grid points
//   c = min(max(z, lo), hi)                         the range is [lo, hi]
//   reading = c + A sin(2 pi (c - lo) / (hi - lo)) + gain_error c + offset + drift (t - start) + noise
//
// y is the position after the first-order low pass, z is y after the delay, c is z limited to the range, t is
// the time. A = nonlinearity * (hi - lo) is the amplitude of the sine error, which is zero at both ends and
// in the middle of the range. If z is outside the range, the electronics saturate, and Reading::in_range is
// false. The reading is rounded to the resolution.
//
// The noise is the sum of two parts. The first part is white, with the standard deviation `noise_um_rms` in
// each sample. The second part n has a density (`noise_density_um_per_rtHz`) and is limited by the bandwidth:
//
//   rms  = density sqrt(pi / 2 * bandwidth),   rho = e^{-omega dt}
//   n[k] = rho n[k-1] + sqrt(1 - rho^2) rms N(0, 1)
//
// n[k] belongs to sample k, dt is the time since sample k-1, and N(0, 1) is a normally distributed random
// number with mean 0 and standard deviation 1. n has the autocorrelation of white noise after a first-order
// low pass, for any sample times. The noise is not delayed, because a delay would not change its statistics.

class Sensor {
 public:
  static constexpr double unbounded_um = std::numeric_limits<double>::infinity();

  struct Config {
    double noise_um_rms = 0.0;               ///< standard deviation of the white noise, >= 0
    double resolution_um = 0.0;              ///< least significant bit; 0: not quantised
    double noise_density_um_per_rtHz = 0.0;  ///< one-sided density of the noise that is
                                             ///< limited by bandwidth_Hz; without bandwidth_Hz: no such noise
    double bandwidth_Hz = 0.0;               ///< -3 dB frequency; 0: unlimited
    can::Duration delay{};
    double drift_um_per_h = 0.0;        ///< drift of the reading, zero at the start
    double nonlinearity_percent = 0.0;  ///< amplitude of an error with the form of a sine over the range,
                                        ///< percent of the range
    double range_min_um = -unbounded_um;
    double range_max_um = unbounded_um;
    double gain_error_percent = 0.0;  ///< error of the gain, percent of the position
    double offset_um = 0.0;
  };
  struct Reading {
    double position_um = 0.0;
    bool in_range = true;
  };

  /// The same seed gives the same noise on every host. `substep` is the time between two calls of
  /// follow().
  explicit Sensor(const Config& config, std::uint64_t seed, can::Time start = {},
                  can::Duration substep = std::chrono::microseconds(50));

  /// Returns true if the reading depends on past positions. follow() must then be called at the end of every
  /// sub-step of the plant.
  bool follows() const { return config_.bandwidth_Hz > 0.0 || config_.delay > can::Duration::zero(); }
  /// Stores the position of the plant at `time`, the end of a sub-step of the plant. Allocates no memory. The
  /// first call sets the start: the sensor is assumed to have been at rest at this position before.
  void follow(can::Time time, double position_um);
  /// Returns the reading at `time` for the true position `position_um`. `time` must not be before the last
  /// call of follow(). measure() changes only the state of the noise.
  Reading measure(can::Time time, double position_um);

 private:
  struct Point {
    can::Time time;
    double position_um = 0.0;  ///< true position of the stage
    double seen_um = 0.0;      ///< position after the low pass of the sensor's bandwidth
  };
  Point low_passed(can::Time time, double position_um) const;
  double delayed_um(const Point& now) const;
  double low_passed_noise(can::Time time);
  const Point& point(std::size_t age) const;

  Config config_;
  can::Time start_;
  can::Duration substep_;
  double omega_;
  double substep_decay_;       ///< factor by which the lag of the low pass decays in one sub-step
  std::vector<Point> points_;  ///< ring buffer of the positions within the sensor's delay
  std::size_t newest_ = 0;
  std::size_t known_ = 0;  ///< number of stored points in points_
  NormalNumbers normal_;
  double density_rms_um_;
  double density_noise_um_ = 0.0;
  can::Time last_sample_{};
  bool has_sampled_ = false;
};

}  // namespace hystcan::twin
