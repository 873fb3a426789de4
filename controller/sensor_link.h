// The sensor's node and its samples.
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
  /// `index`: of its axis.
  SensorLink(const can::AxisWire& wire, std::size_t index, can::Duration heartbeat_timeout,
             const can::Database& database, SharedFrames& frames);

  Heartbeat on_heartbeat(const can::Frame& frame, can::Time now);
  /// The sample in a frame that samples() has accepted. Empty where it names a SYNC that there is not; the
  /// log says so.
  std::optional<can::SensorSample> on_sample(const can::Frame& frame, std::uint64_t cycle);
  /// The last sample and another one name the same SYNC (SampleFrame).
  bool is_doubled() const { return is_doubled_; }
  /// False: the sample is of another cycle. Where samples do not name their SYNC, they count for the cycle in
  /// which they arrive.
  bool is_of(const can::SensorSample& sample, std::uint8_t sync_counter) const {
    return !sync_place_ || sample.sync_counter == sync_counter;
  }
  void note_late_sample() { late_sample_ = true; }
  /// Its sample came before the deadline of the command.
  void note_sample_in_time(std::uint64_t cycle) { heard_in_ = cycle; }
  /// As many lost samples as the axis bridges do not end the waiting for the next.
  bool is_awaited(std::uint64_t cycle, unsigned bridged) const { return cycle - heard_in_ <= bridged + 1ULL; }
  /// The bus was off or the interface down: what is known of the node may no longer hold.
  void on_bus_loss();

  /// What is known for the next step. Each event since the last step counts once.
  void take_health(can::Time now, AxisInput& input);
  SampleFrame& samples() const { return samples_; }

 private:
  can::Layout<can::SensorSample> layout_;
  SampleFrame& samples_;
  std::optional<std::size_t> sync_place_;  ///< Of its counter of the SYNC; empty: samples do not name it.
  bool is_doubled_ = false;
  bool late_sample_ = false;    ///< A sample came too late since the last step.
  std::uint64_t heard_in_ = 0;  ///< the last cycle whose sample came in time
};

}  // namespace hystcan::controller
