// Sends a ScanMarker at the beginning of each line of a raster, if the configuration requests it.
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

  /// Called once for each step of the axis. When a line of the raster begins, a marker becomes due. It
  /// replaces an earlier marker that has not been sent.
  void note(const AxisReport& report, std::uint8_t sync_counter);
  bool is_due() const { return due_.has_value(); }
  /// Returns false if the bus refused the frame, which then stays due.
  bool send(can::Bus& bus);

 private:
  can::Encoder<can::ScanMarker> encode_;
  std::optional<ScanPlace> place_;  ///< place of the scan in the previous step of the axis
  std::optional<can::ScanMarker> due_;
};

}  // namespace hystcan::controller
