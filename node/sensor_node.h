// The position sensor as a node on the bus. It samples either when a SYNC arrives, or at the rate of its own
// clock.
//
// A free-running sensor samples every 1 / (rate (1 + skew)) after the node becomes operational; each sample
// contains the counter of the last received SYNC. The phase between samples and SYNCs drifts by the skew;
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

/// A frame contains the samples of all axes of the node, which are taken at the same time.
class SensorNode final : public BusNode {
 public:
  /// `first`: the first axis of the node. Throws std::invalid_argument if a free-running clock has no rate.
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
  /// Sends an emergency when a device fails, and another one when all devices work again.
  void report_failures();

  can::Scheduler& scheduler_;
  SampleClock sample_clock_;
  double period_ns_;  ///< period of the sensor's own clock
  std::unique_ptr<can::Timer> clock_;
  can::Time clock_started_{};
  std::int64_t ticks_ = 0;  ///< ticks of that clock since clock_started_
  bool has_failed_ = false;
  std::uint8_t last_sync_ = 0;  ///< counter of the last received SYNC; 0: none yet
  can::E2eProtector protector_;
  std::vector<SensorChannel*> channels_;
};

}  // namespace hystcan::node
