// Receives the live setpoints of one axis, if the configuration allows them. Counts refused setpoints by
// reason.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "can/protocol/protocol.h"
#include "controller/control/axis.h"

namespace hystcan::controller {

/// Numbers of live setpoints that arrived in valid frames, by result.
struct SetpointCounters {
  std::uint64_t taken = 0;
  std::uint64_t not_tracking = 0;
  std::uint64_t out_of_range = 0;
  std::uint64_t unknown_mode = 0;

  std::uint64_t refused() const { return not_tracking + out_of_range + unknown_mode; }
};
/// Describes the counters. Example: "2 live setpoints accepted, refused: 1 not tracking, 3 out of range".
/// Returns an empty text if no setpoint has arrived.
std::string describe(const SetpointCounters& counters);

class SetpointReceiver {
 public:
  explicit SetpointReceiver(can::Layout<can::Setpoint> layout) : decode_(std::move(layout)) {}

  void on_frame(const can::Frame& frame, Axis& axis);
  std::uint32_t id() const { return decode_.id(); }
  const can::E2eChecker& checker() const { return decode_.checker(); }
  const SetpointCounters& counters() const { return counters_; }

 private:
  can::Decoder<can::Setpoint> decode_;
  SetpointCounters counters_;
};

}  // namespace hystcan::controller
