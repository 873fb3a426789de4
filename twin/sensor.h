// The position sensor: bandwidth, delay, characteristic, drift, noise, quantisation.
//
//   y' = omega (x - y),  omega = 2 pi bandwidth         exact for a position that is linear between grid
//   points z(t) = y(t - delay)                                 linear between grid points reading = c + A
//   sin(2 pi (c - lo) / (hi - lo)) + gain_error c + offset + drift (t - start) + noise
//
// c is z held within the range [lo, hi]; A = nonlinearity * (hi - lo), an error that is zero at both ends and
// in the middle of the range. Beyond the range the electronics is saturated, and the reading says so. What is
// read is rounded to the resolution.
//
// Noise: white of `noise_um_rms` for each sample, and that of a density behind the bandwidth,
//   rms = density sqrt(pi / 2 * bandwidth),   n[k] = rho n[k-1] + sqrt(1 - rho^2) rms N(0, 1),
// rho = e^{-omega dt}, dt since the last sample: the autocorrelation of white noise through a first-order low
// pass, whatever the times of the samples. It is not delayed: its statistics would be the same.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cstdint>
#include <limits>
#include <vector>

#include "can/scheduler.h"

namespace hystcan::twin {

class Sensor {
 public:
  static constexpr double unbounded_um = std::numeric_limits<double>::infinity();

  struct Config {
    double noise_um_rms = 0.0;               ///< standard deviation of one sample, >= 0
    double resolution_um = 0.0;              ///< least significant bit; 0: not quantised
    double noise_density_um_per_rtHz = 0.0;  ///< one-sided, with a bandwidth
    double bandwidth_Hz = 0.0;               ///< -3 dB; 0: unlimited
    can::Duration delay{};
    double drift_um_per_h = 0.0;        ///< from the start on
    double nonlinearity_percent = 0.0;  ///< A of the range
    double range_min_um = -unbounded_um;
    double range_max_um = unbounded_um;
    double gain_error_percent = 0.0;  ///< of the position
    double offset_um = 0.0;
  };
  struct Reading {
    double position_um = 0.0;
    bool in_range = true;
  };

  /// The same seed gives the same noise on every host. `substep`: between grid points.
  explicit Sensor(const Config& config, std::uint64_t seed, can::Time start = {},
                  can::Duration substep = std::chrono::microseconds(50));

  /// It has to be told of the grid points: what it reads depends on the past.
  bool follows() const { return config_.bandwidth_Hz > 0.0 || config_.delay > can::Duration::zero(); }
  /// A grid point of the plant, in order; the first one is where the sensor has rested. Allocates nothing.
  void follow(can::Time time, double position_um);
  /// The sample at `time`, not before the last grid point. Only the noise goes on by it.
  Reading measure(can::Time time, double position_um);

 private:
  struct Point {
    can::Time time;
    double position_um = 0.0;  ///< x
    double seen_um = 0.0;      ///< y
  };
  Point low_passed(can::Time time, double position_um) const;
  double delayed_um(const Point& now) const;
  double low_passed_noise(can::Time time);
  const Point& point(std::size_t age) const;

  Config config_;
  can::Time start_;
  can::Duration substep_;
  double omega_;
  double substep_decay_;       ///< e^{-omega substep}
  std::vector<Point> points_;  ///< a ring of as many as the delay needs
  std::size_t newest_ = 0;
  std::size_t known_ = 0;  ///< points that are there
  boost::random::mt19937_64 random_;
  boost::random::normal_distribution<double> normal_;
  double density_rms_um_;
  double density_noise_um_ = 0.0;
  can::Time last_sample_{};
  bool has_sampled_ = false;
};

}  // namespace hystcan::twin
