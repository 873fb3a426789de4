// The position sensor: its physics, and its node on the bus.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "can/bus.h"
#include "can/protocol/protocol.h"
#include "can/scheduler.h"
#include "twin/bus_node.h"
#include "twin/noise.h"
#include "twin/plant.h"

namespace hystcan::twin {

struct WiredAxisConfig;  // twin/config.h
struct CommonConfig;

// The position sensor: bandwidth, delay, characteristic, drift, noise, quantisation.
//
//   y' = omega (x - y),  omega = 2 pi bandwidth     exact for a position that is linear between grid points
//   z(t) = y(t - delay)                             linear between grid points
//   c = min(max(z, lo), hi)                         the range is [lo, hi]
//   reading = c + A sin(2 pi (c - lo) / (hi - lo)) + gain_error c + offset + drift (t - start) + noise
//
// A = nonlinearity * (hi - lo): this error is zero at both ends and in the middle of the range. Beyond the
// range the electronics saturates, and the reading reports it. The reading is rounded to the resolution.
//
// The noise is the sum of white noise with `noise_um_rms` per sample and of noise n with a density, limited
// by the bandwidth; dt is the time since the last sample:
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
    double noise_density_um_per_rtHz = 0.0;  ///< one-sided, with a bandwidth
    double bandwidth_Hz = 0.0;               ///< -3 dB; 0: unlimited
    can::Duration delay{};
    double drift_um_per_h = 0.0;        ///< from the start on
    double nonlinearity_percent = 0.0;  ///< A in percent of the range
    double range_min_um = -unbounded_um;
    double range_max_um = unbounded_um;
    double gain_error_percent = 0.0;  ///< of the position
    double offset_um = 0.0;
  };
  struct Reading {
    double position_um = 0.0;
    bool in_range = true;
  };

  /// The same seed gives the same noise on every host. `substep`: time between grid points.
  explicit Sensor(const Config& config, std::uint64_t seed, can::Time start = {},
                  can::Duration substep = std::chrono::microseconds(50));

  /// True: the reading depends on the past, so follow() must be called at every grid point.
  bool follows() const { return config_.bandwidth_Hz > 0.0 || config_.delay > can::Duration::zero(); }
  /// Takes the grid points of the plant in order; the sensor rests at the first one until then. Allocates
  /// nothing.
  void follow(can::Time time, double position_um);
  /// The sample at `time`, which is not before the last grid point. Changes only the state of the noise.
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
  std::vector<Point> points_;  ///< a ring that is long enough for the delay
  std::size_t newest_ = 0;
  std::size_t known_ = 0;  ///< number of points in the ring
  NormalNumbers normal_;
  double density_rms_um_;
  double density_noise_um_ = 0.0;
  can::Time last_sample_{};
  bool has_sampled_ = false;
};

// The position sensor as a node on the bus. It takes one sample per SYNC, when the SYNC arrives, or it
// samples by its own clock.
//
// A free-running sensor samples every 1 / (rate (1 + skew)) after it has become operational; each sample
// names the last received SYNC. Its phase to the SYNCs drifts by the skew; docs/protocol/nodes.md describes
// how the controller handles this.

/// Bits of SensorSample.Status.
namespace sensor_status {
inline constexpr std::uint8_t out_of_range = 0x01;  ///< the reading is saturated
}  // namespace sensor_status

enum class Sampling : std::uint8_t { sync, free };
constexpr auto words(Sampling) { return std::to_array<std::string_view>({"sync", "free"}); }

/// When the sensor samples.
struct SampleClock {
  Sampling sampling = Sampling::sync;
  double rate_Hz = 0.0;   ///< free-running: by its own clock, > 0
  double skew_ppm = 0.0;  ///< relative speed error of that clock; > 0: it is fast

  friend bool operator==(const SampleClock&, const SampleClock&) = default;
};

class SensorChannel;

/// A frame holds the samples of all axes of the node, which are taken at one time.
class SensorNode final : public BusNode {
 public:
  /// `first`: the first of its axes. Throws std::invalid_argument where a free-running clock has no rate.
  SensorNode(const WiredAxisConfig& first, const CommonConfig& common, const can::Database& database,
             can::Scheduler& scheduler, const can::Attach& attach);

 private:
  friend class SensorChannel;
  void add(SensorChannel& channel, const SampleClock& clock);
  void on_nmt(can::NmtState state) override;
  void on_sync(std::uint8_t counter, can::Time received);
  void on_clock();
  void sample(can::Time time);

  can::Scheduler& scheduler_;
  SampleClock sample_clock_;
  double period_ns_;  ///< of its own clock
  std::unique_ptr<can::Timer> clock_;
  can::Time clock_started_{};
  std::int64_t ticks_ = 0;      ///< of its own clock, since clock_started_
  std::uint8_t last_sync_ = 0;  ///< counter of the last received SYNC; 0: none yet
  can::E2eProtector protector_;
  std::vector<SensorChannel*> channels_;
};

/// The sensor of one axis.
class SensorChannel {
 public:
  /// Throws std::invalid_argument where another axis of the node has another clock.
  SensorChannel(const WiredAxisConfig& config, const CommonConfig& common, const can::Database& database,
                can::Time start, SensorNode& node, Plant& plant);
  SensorChannel(const SensorChannel&) = delete;
  SensorChannel& operator=(const SensorChannel&) = delete;

  SensorNode& node() const { return node_; }
  std::size_t index() const { return index_; }  ///< among the channels of the node

  /// True: the reading depends on the past, so follow() must be called at every grid point of the plant.
  bool follows_the_plant() const { return sensor_.follows(); }
  void follow(can::Time time, double position_um) { sensor_.follow(time, position_um); }

  /// The handler is called at each sample, with the sample that will be sent.
  using SampleHandler = std::function<void(can::Time, const can::SensorSample&)>;
  void on_sample(SampleHandler handler) { on_sample_ = std::move(handler); }

 private:
  friend class SensorNode;
  /// Measures, and writes the sample into the frame; returns false where the message cannot carry it.
  bool sample(can::Time time, std::uint8_t sync_counter, can::Frame& frame);

  SensorNode& node_;
  std::size_t index_;
  Plant& plant_;
  Sensor sensor_;
  can::Layout<can::SensorSample> layout_;
  can::SensorSample sample_;
  SampleHandler on_sample_;
};

}  // namespace hystcan::twin
