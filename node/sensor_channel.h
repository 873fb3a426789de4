// The sensor of one axis, a channel of a sensor node.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>

#include "node/position_input.h"
#include "node/sensor_node.h"

namespace hystcan::node {

class SensorChannel {
 public:
  /// Adds the channel to `node`. Throws std::invalid_argument if `clock` differs from the sample clock of the
  /// node.
  SensorChannel(const can::AxisWire& wire, const SampleClock& clock, const can::Database& database,
                SensorNode& node, PositionInput& input);
  SensorChannel(const SensorChannel&) = delete;
  SensorChannel& operator=(const SensorChannel&) = delete;

  SensorNode& node() const { return node_; }
  std::size_t index() const { return index_; }  ///< index among the channels of the node
  /// Returns true if the last sample has no position.
  bool has_failed() const { return (sample_.status & sensor_status::no_position) != 0; }

  /// Sets a handler that is called for each sample, before the sample is sent.
  using SampleHandler = std::function<void(can::Time, const can::SensorSample&)>;
  void on_sample(SampleHandler handler) { on_sample_ = std::move(handler); }

 private:
  friend class SensorNode;
  /// Reads the position and writes the sample into the frame. Returns false if the message cannot represent
  /// the sample; the node must then not send the frame.
  bool sample(can::Time time, std::uint8_t sync_counter, can::Frame& frame);

  SensorNode& node_;
  std::size_t index_;
  PositionInput& input_;
  can::Layout<can::SensorSample> layout_;
  bool sends_status_;
  can::SensorSample sample_;
  SampleHandler on_sample_;
};

}  // namespace hystcan::node
