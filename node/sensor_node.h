// The position sensor as a node on the bus. It takes one sample per SYNC, when the SYNC arrives, or it
// samples by its own clock.
//
// A free-running sensor samples every 1 / (rate (1 + skew)) after it has become operational; each sample
// names the last received SYNC. Its phase to the SYNCs drifts by the skew; docs/protocol/nodes.md describes
// how the controller handles this.

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

/// A frame holds the samples of all axes of the node, which are taken at one time.
class SensorNode final : public BusNode {
 public:
  /// `first`: the first of its axes. Throws std::invalid_argument where a free-running clock has no rate.
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
  /// Sends an emergency when a device fails, and another one when all work again.
  void report_failures();

  can::Scheduler& scheduler_;
  SampleClock sample_clock_;
  double period_ns_;  ///< of its own clock
  std::unique_ptr<can::Timer> clock_;
  can::Time clock_started_{};
  std::int64_t ticks_ = 0;  ///< of its own clock, since clock_started_
  bool has_failed_ = false;
  std::uint8_t last_sync_ = 0;  ///< counter of the last received SYNC; 0: none yet
  can::E2eProtector protector_;
  std::vector<SensorChannel*> channels_;
};

}  // namespace hystcan::node
