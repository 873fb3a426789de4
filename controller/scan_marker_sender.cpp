#include "controller/scan_marker_sender.h"

namespace hystcan::controller {

void ScanMarkerSender::note(const AxisReport& report, std::uint8_t sync_counter) {
  const std::optional<ScanPlace> now =
      report.state == AxisState::tracking ? report.point.scan : std::optional<ScanPlace>{};
  const std::optional<ScanPlace> before = std::exchange(place_, now);
  if (!now || (before && before->line == now->line && before->frame == now->frame)) return;
  due_ = {.line = static_cast<std::uint16_t>(now->line),
          .frame = static_cast<std::uint16_t>(now->frame),
          .sync_counter = sync_counter};
}

bool ScanMarkerSender::send(can::Bus& bus) {
  const auto frame = encode_(*due_);
  if (frame && !bus.send(*frame)) return false;
  due_.reset();
  return true;
}

}  // namespace hystcan::controller
