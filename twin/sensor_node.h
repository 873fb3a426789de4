// The position sensor as a node on the bus. It takes one sample per SYNC, when the SYNC arrives, or it
// samples by its own clock.
//
// A free-running sensor samples every 1 / (rate (1 + skew)) after it has become operational; each sample
// names the last received SYNC. Its phase to the SYNCs drifts by the skew; docs/protocol.md describes how
// the controller handles this.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <utility>

#include "can/bus.h"
#include "can/protocol/node.h"
#include "can/protocol/protocol.h"
#include "twin/plant.h"
#include "twin/sensor.h"

namespace hystcan::twin {

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
};

class SensorNode {
 public:
  struct Config {
    can::AxisWire wire;
    can::Duration heartbeat_period{};
    SampleClock clock{};
  };

  /// Throws std::invalid_argument where a free-running clock has no rate.
  SensorNode(const Config& config, const can::Database& database, can::Scheduler& scheduler,
             std::unique_ptr<can::Bus> bus, Plant& plant, Sensor sensor);
  SensorNode(const SensorNode&) = delete;
  SensorNode& operator=(const SensorNode&) = delete;

  void start() { nmt_.start(); }
  /// Another node on the bus has the same number: this node is off and silent.
  bool is_taken() const { return nmt_.is_taken(); }

  const can::Bus& bus() const { return *bus_; }
  can::NmtState state() const { return nmt_.state(); }
  bool is_on_the_bus() const { return !nmt_.is_silent(); }

  /// The supply returns: the node starts as at its first start. No effect before the first start.
  void restart();

  /// True: the reading depends on the past, so follow() must be called at every grid point of the plant.
  bool follows_the_plant() const { return sensor_.follows(); }
  void follow(can::Time time, double position_um) { sensor_.follow(time, position_um); }

  /// The handler is called at each sample, with the sample that will be sent.
  using SampleHandler = std::function<void(can::Time, const can::SensorSample&)>;
  void on_sample(SampleHandler handler) { on_sample_ = std::move(handler); }

 private:
  void handle(const can::Frame& frame, can::Time received);
  void on_nmt(can::NmtState state);
  void on_sync(std::uint8_t counter, can::Time received);
  void on_clock();
  void sample(can::Time time);
  void boot_up();

  can::Scheduler& scheduler_;
  std::unique_ptr<can::Bus> bus_;
  Plant& plant_;
  Sensor sensor_;
  bool runs_free_;
  double period_ns_;  ///< of its own clock
  std::unique_ptr<can::Timer> clock_;
  can::Time clock_started_{};
  std::int64_t ticks_ = 0;      ///< of its own clock, since clock_started_
  std::uint8_t last_sync_ = 0;  ///< counter of the last received SYNC; 0: none yet
  can::NmtSlave nmt_;
  can::SdoServer sdo_;
  can::Encoder<can::SensorSample> encode_sample_;
  can::Encoder<can::SensorSample> encode_sample_at_power_on_;
  SampleHandler on_sample_;
};

}  // namespace hystcan::twin
