#include "controller/status_sender.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::controller {
namespace {

/// Returns the status of the axis. The following error in it is limited to the width of the range of
/// plausible positions.
can::ControllerStatus status_of(const Axis& axis) {
  const AxisReport& report = axis.report();
  can::ControllerStatus status{.state = static_cast<std::uint8_t>(axis.state()),
                               .cause = static_cast<std::uint8_t>(axis.fault().cause)};
  if (axis.state() != AxisState::tracking) return status;
  const double error_um = report.reference_um - report.position_um;
  const double width_um =
      axis.config().supervision.position_max_um - axis.config().supervision.position_min_um;
  if (std::isfinite(error_um)) status.following_error_um = std::clamp(error_um, -width_um, width_um);
  status.in_position = report.arrival == Arrival::in_position;
  status.limited = report.limits != limit::none;
  status.reference_finished = report.point.finished;
  return status;
}

}  // namespace

StatusSender::StatusSender(const can::Database& database, const can::AxisWire& wire) {
  auto layout = can::find_layout<can::ControllerStatus>(database, wire);
  if (!layout) return;
  foreign_.emplace(layout->checker());
  encode_.emplace(std::move(*layout));
}

std::optional<std::uint32_t> StatusSender::id() const {
  if (!encode_) return std::nullopt;
  return encode_->id();
}

bool StatusSender::is_due(const Axis& axis) const {
  return encode_ && (due_ || axis.state() != sent_state_ || axis.fault().cause != sent_cause_);
}

bool StatusSender::send(const Axis& axis, can::Bus& bus) {
  const can::ControllerStatus status = status_of(axis);
  const auto frame = (*encode_)(status);
  if (frame && !bus.send(*frame)) return false;
  due_ = false;
  sent_state_ = axis.state();
  sent_cause_ = axis.fault().cause;
  return true;
}

}  // namespace hystcan::controller
