// The position sensor as a node on the bus. The sensor takes a sample when a SYNC arrives, or runs free: it
// then takes samples by its own clock.
//
// A free-running sensor has the sample period 1 / (rate_Hz (1 + 1e-6 skew_ppm)); rate_Hz and skew_ppm are
// members of SampleClock. The first sample is due when the node becomes operational. Each sample contains the
// counter of the last received SYNC. Because the two clocks differ, the samples drift against the SYNCs;
// docs/protocol/nodes.md describes how the controller handles this drift.

#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "can/bus.h"
#include "can/protocol/protocol.h"
#include "node/bus_node.h"
#include "node/config.h"

namespace hystcan::node {

class SensorChannel;

/// A node with the sensors of one or several axes. The sensors take their samples at the same time, and one
/// frame contains the samples of all axes.
class SensorNode final : public BusNode {
 public:
  /// `first`: the first axis of the node. Its sample message applies to all axes of the node. Throws
  /// std::invalid_argument if the sensor runs free but `clock` has no sample rate.
  SensorNode(const can::AxisWire& first, const SampleClock& clock, const CommonConfig& common,
             const can::Database& database, can::Scheduler& scheduler, const can::Attach& attach);
  const std::vector<SensorChannel*>& channels() const { return channels_; }

 private:
  friend class SensorChannel;
  void add(SensorChannel& channel, const SampleClock& clock);
  void on_nmt(can::NmtState state) override;
  void on_sync(std::uint8_t counter, can::Time received);
  void on_clock();
  void sample(can::Time time);
  /// Sends an emergency frame when a sensor fails and all sensors worked before. Sends an emergency frame
  /// with the error code 0 (no error) when all sensors work again.
  void report_failures();

  can::Scheduler& scheduler_;
  SampleClock sample_clock_;
  double period_ns_;  ///< period of the sensor's own clock
  std::unique_ptr<can::Timer> clock_;
  can::Time clock_started_{};
  std::int64_t ticks_ = 0;  ///< ticks of the sensor's own clock since clock_started_
  bool has_failed_ = false;
  std::uint8_t last_sync_ = 0;  ///< counter of the last received SYNC; 0: no SYNC yet
  can::E2eProtector protector_;
  std::vector<SensorChannel*> channels_;
};

}  // namespace hystcan::node
