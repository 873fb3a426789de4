// The connection to one sensor: its node and its samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "can/dbc/database.h"
#include "can/protocol/protocol.h"
#include "controller/control/supervisor.h"
#include "controller/remote_node.h"
#include "controller/shared_frames.h"

namespace hystcan::controller {

class SensorLink : public RemoteNode {
 public:
  /// `index`: index of the sensor's axis in the controller.
  SensorLink(const can::AxisWire& wire, std::size_t index, can::Duration heartbeat_timeout,
             const can::Database& database, SharedFrames& frames);

  Heartbeat on_heartbeat(const can::Frame& frame, can::Time now);
  /// Decodes the sample in a frame that samples() has accepted. Returns `nullopt` and logs an event if the
  /// SYNC counter in the sample is not valid.
  std::optional<can::SensorSample> on_sample(const can::Frame& frame, std::uint64_t cycle);
  /// True if the last sample and a different earlier sample have the same SYNC counter (SampleFrame).
  bool is_doubled() const { return is_doubled_; }
  /// True if the sample belongs to this cycle. Samples without a SYNC counter belong to the cycle in which
  /// they arrive.
  bool is_of(const can::SensorSample& sample, std::uint8_t sync_counter) const {
    return !sync_place_ || sample.sync_counter == sync_counter;
  }
  void note_late_sample() { late_sample_ = true; }
  /// Records that the sample of this cycle arrived before the deadline of the command.
  void note_sample_in_time(std::uint64_t cycle) { heard_in_ = cycle; }
  /// True while the controller waits for the next sample. It does not wait any more if the number of
  /// consecutive lost samples exceeds `bridged`, the number that the axis tolerates.
  bool is_awaited(std::uint64_t cycle, unsigned bridged) const { return cycle - heard_in_ <= bridged + 1ULL; }
  /// Called after the bus was off or the interface down: discards the state of the node, which may not be
  /// valid any more.
  void on_bus_loss();

  /// Fills `input` with the state of the sensor for the next step of the axis. An event since the last step
  /// is reported once.
  void take_health(can::Time now, AxisInput& input);
  SampleFrame& samples() const { return samples_; }

 private:
  can::Layout<can::SensorSample> layout_;
  SampleFrame& samples_;
  /// Index of the SYNC counter in SampleFrame; empty: the samples have no SYNC counter.
  std::optional<std::size_t> sync_place_;
  bool is_doubled_ = false;
  bool late_sample_ = false;    ///< True if a sample arrived too late since the last step.
  std::uint64_t heard_in_ = 0;  ///< The last cycle whose sample arrived in time.
};

}  // namespace hystcan::controller
