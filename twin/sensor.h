// The physics of the position sensor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "can/scheduler.h"
#include "twin/noise.h"

namespace hystcan::twin {

// The position sensor: bandwidth, delay, characteristic, drift, noise, quantisation.
//
//   y' = omega (x - y),  omega = 2 pi bandwidth     exact for a position that is linear between grid points
//   z(t) = y(t - delay)                             linear between grid points
//   c = min(max(z, lo), hi)                         the range is [lo, hi]
//   reading = c + A sin(2 pi (c - lo) / (hi - lo)) + gain_error c + offset + drift (t - start) + noise
//
// A = nonlinearity * (hi - lo): this error is zero at both ends and in the middle of the range. Outside the
// range the electronics saturate, and the reading reports this. The reading is rounded to the resolution.
//
// The noise is the sum of white noise with `noise_um_rms` per sample and of noise n with a density, limited
// by the bandwidth; dt is the time since the previous sample:
//
//   rms  = density sqrt(pi / 2 * bandwidth),   rho = e^{-omega dt}
//   n[k] = rho n[k-1] + sqrt(1 - rho^2) rms N(0, 1)
//
// This is the autocorrelation of white noise after a first-order low pass, for any sample times. The noise is
// not delayed, because a delay would not change its statistics.

class Sensor {
 public:
  static constexpr double unbounded_um = std::numeric_limits<double>::infinity();

  struct Config {
    double noise_um_rms = 0.0;               ///< standard deviation of one sample, >= 0
    double resolution_um = 0.0;              ///< least significant bit; 0: not quantised
    double noise_density_um_per_rtHz = 0.0;  ///< one-sided density; needs a bandwidth
    double bandwidth_Hz = 0.0;               ///< -3 dB; 0: unlimited
    can::Duration delay{};
    double drift_um_per_h = 0.0;        ///< since the start
    double nonlinearity_percent = 0.0;  ///< amplitude of the sine error, percent of the range
    double range_min_um = -unbounded_um;
    double range_max_um = unbounded_um;
    double gain_error_percent = 0.0;  ///< percent of the position
    double offset_um = 0.0;
  };
  struct Reading {
    double position_um = 0.0;
    bool in_range = true;
  };

  /// The same seed gives the same noise on every host. `substep`: time between grid points.
  explicit Sensor(const Config& config, std::uint64_t seed, can::Time start = {},
                  can::Duration substep = std::chrono::microseconds(50));

  /// Returns true if the reading depends on the past; follow() must then be called at every grid point.
  bool follows() const { return config_.bandwidth_Hz > 0.0 || config_.delay > can::Duration::zero(); }
  /// Stores the next grid point of the plant, without allocating. Before the first point, the sensor was at
  /// rest at the position of that point.
  void follow(can::Time time, double position_um);
  /// Returns the sample at `time`, which must not be before the last grid point. Changes only the state of
  /// the noise.
  Reading measure(can::Time time, double position_um);

 private:
  struct Point {
    can::Time time;
    double position_um = 0.0;  ///< x, input of the sensor
    double seen_um = 0.0;      ///< y, after the low pass of the bandwidth
  };
  Point low_passed(can::Time time, double position_um) const;
  double delayed_um(const Point& now) const;
  double low_passed_noise(can::Time time);
  const Point& point(std::size_t age) const;

  Config config_;
  can::Time start_;
  can::Duration substep_;
  double omega_;
  double substep_decay_;       ///< decay factor of the low pass in a sub-step: e^{-omega substep}
  std::vector<Point> points_;  ///< ring buffer of the grid points within the delay
  std::size_t newest_ = 0;
  std::size_t known_ = 0;  ///< number of points in the ring
  NormalNumbers normal_;
  double density_rms_um_;
  double density_noise_um_ = 0.0;
  can::Time last_sample_{};
  bool has_sampled_ = false;
};

}  // namespace hystcan::twin
