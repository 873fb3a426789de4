// Sends a ScanMarker at the beginning of each line of a raster, where the configuration asks for it.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "can/bus.h"
#include "can/protocol/protocol.h"
#include "controller/control/axis_report.h"

namespace hystcan::controller {

class ScanMarkerSender {
 public:
  explicit ScanMarkerSender(can::Layout<can::ScanMarker> layout) : encode_(std::move(layout)) {}

  /// Once for each step of the axis. A line that begins becomes due, in the place of one that was not sent.
  void note(const AxisReport& report, std::uint8_t sync_counter);
  bool is_due() const { return due_.has_value(); }
  /// False if the bus refused the frame, which then stays due.
  bool send(can::Bus& bus);

 private:
  can::Encoder<can::ScanMarker> encode_;
  std::optional<ScanPlace> place_;  ///< in the last step
  std::optional<can::ScanMarker> due_;
};

}  // namespace hystcan::controller
