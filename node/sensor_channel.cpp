#include "node/sensor_channel.h"

namespace hystcan::node {

SensorChannel::SensorChannel(const can::AxisWire& wire, const SampleClock& clock,
                             const can::Database& database, SensorNode& node, PositionInput& input)
    : node_(node),
      index_(node.channels_.size()),
      input_(input),
      layout_(*can::find_layout<can::SensorSample>(database, wire)),
      sends_status_(can::message_map<can::SensorSample>(wire)->carries("status")) {
  node_.add(*this, clock);
}

// If the input has failed and the message has no status signal to report this, the function returns false, so
// that the node sends no sample.
bool SensorChannel::sample(can::Time time, std::uint8_t sync_counter, can::Frame& frame) {
  const PositionInput::Reading reading = input_.read(time);
  sample_ = {.position_um = reading.position_um, .sync_counter = sync_counter, .status = reading.status};
  return (sends_status_ || !has_failed()) && layout_.put(sample_, frame);
}

}  // namespace hystcan::node
