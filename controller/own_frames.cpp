#include "controller/own_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace hystcan::controller {
namespace {

template <class Payload>
can::Layout<Payload> layout_of(const can::Database& database, const can::AxisWire& wire, const char* what) {
  if (auto layout = can::find_layout<Payload>(database, wire)) return std::move(*layout);
  throw std::invalid_argument("no message " + wire.message_prefix + std::string(Payload::name) +
                              ", expected one for the " + what + " of axis " + wire.name);
}

}  // namespace

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

ScanMarkerSender::ScanMarkerSender(const can::Database& database, const can::AxisWire& wire)
    : encode_(layout_of<can::ScanMarker>(database, wire, "scan markers")) {}

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

std::string describe(const SetpointCounters& counters) {
  if (counters.taken + counters.refused() == 0) return {};
  std::string text = fmt::format("{} live setpoints taken", counters.taken);
  const std::array<std::pair<std::uint64_t, const char*>, 3> reasons{
      {{counters.not_tracking, "not tracking"},
       {counters.out_of_range, "out of range"},
       {counters.unknown_mode, "unknown mode"}}};
  const char* before = ", refused: ";
  for (const auto& [count, reason] : reasons)
    if (count > 0) text += fmt::format("{}{} {}", std::exchange(before, ", "), count, reason);
  return text;
}

SetpointReceiver::SetpointReceiver(const can::Database& database, const can::AxisWire& wire)
    : decode_(layout_of<can::Setpoint>(database, wire, "live setpoints")) {}

void SetpointReceiver::on_frame(const can::Frame& frame, Axis& axis) {
  const auto setpoint = decode_(frame);
  if (!setpoint) return;
  if (setpoint->mode > can::setpoint_mode::go_to) {
    ++counters_.unknown_mode;
    return;
  }
  const std::optional<Refusal> refusal =
      setpoint->mode == can::setpoint_mode::go_to ? axis.go_to(setpoint->position_um) : axis.resume();
  if (!refusal) ++counters_.taken;
  if (refusal == Refusal::not_tracking) ++counters_.not_tracking;
  if (refusal == Refusal::position_out_of_range) ++counters_.out_of_range;
}

}  // namespace hystcan::controller
