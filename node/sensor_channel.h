// The sensor of one axis: its node's channel.
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
  /// Throws std::invalid_argument where another axis of the node has another clock.
  SensorChannel(const can::AxisWire& wire, const SampleClock& clock, const can::Database& database,
                SensorNode& node, PositionInput& input);
  SensorChannel(const SensorChannel&) = delete;
  SensorChannel& operator=(const SensorChannel&) = delete;

  SensorNode& node() const { return node_; }
  std::size_t index() const { return index_; }  ///< among the channels of the node
  /// Its last sample has no position.
  bool has_failed() const { return (sample_.status & sensor_status::no_position) != 0; }

  /// The handler is called at each sample, with the sample that will be sent.
  using SampleHandler = std::function<void(can::Time, const can::SensorSample&)>;
  void on_sample(SampleHandler handler) { on_sample_ = std::move(handler); }

 private:
  friend class SensorNode;
  /// Reads the input, and writes the sample into the frame; returns false where the message cannot carry it.
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
