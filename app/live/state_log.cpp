#include "app/live/state_log.h"

#include <fmt/format.h>

#include <utility>

namespace hystcan::app {
namespace {

using controller::AxisState;
using controller::Lack;
using Level = can::BusHealthLog::Level;

/// What an axis lacks for less than this is the ordinary course of a start.
constexpr double worth_a_line_s = 2.0;

bool is_on_its_way(AxisState state) {
  return state == AxisState::waiting || state == AxisState::initialising;
}

}  // namespace

StateLog::StateLog(const config::Config& config, can::BusHealthLog::Sink sink)
    : sink_(std::move(sink)), events_(sink_) {
  for (const config::AxisConfig& axis : config.axes)
    axes_.push_back({.name = axis.wire.name,
                     .amplifier_node = axis.wire.amplifier_node,
                     .sensor_node = axis.wire.sensor_node,
                     .drive_min = axis.control.gate.drive_min,
                     .drive_max = axis.control.gate.drive_max,
                     .drive_unit = axis.wire.drive_unit});
}

void StateLog::add(const controller::CycleRecord& record) {
  Axis& axis = axes_[record.axis];
  events_.add(axis.name, record);
  if (const auto& after_s = record.report.watchdog_tripped_after_s)
    sink_(Level::info,
          fmt::format("{}: watchdog of the amplifier (node {}) verified: tripped after {:.0f} ms", axis.name,
                      axis.amplifier_node, 1e3 * *after_s));
  if (axis.state != record.report.state) add_state(axis, record);
  add_lack(axis, record);
}

void StateLog::add_state(Axis& axis, const controller::CycleRecord& record) {
  const controller::AxisReport& report = record.report;
  axis.state = report.state;
  if (report.state == AxisState::faulted)
    sink_(Level::error, fmt::format("{}: faulted at {:.3f} s: {}; {}", axis.name, report.fault_time_s,
                                    to_string(report.cause), remedy(report.cause)));
  else if (report.state == AxisState::waiting)
    sink_(Level::info, fmt::format("{}: waiting for amplifier node {} and sensor node {}", axis.name,
                                   axis.amplifier_node, axis.sensor_node));
  else
    sink_(Level::info, fmt::format("{}: {}", axis.name, to_string(report.state)));
  if (report.state != AxisState::tracking) return;
  if (!std::exchange(has_tracked_, true)) add_missing_axes();
}

/// When the first axes begin. The other axes of their cycle come after this one: those that are ready are not missing.
void StateLog::add_missing_axes() {
  for (const Axis& axis : axes_)
    if (is_on_its_way(axis.state))
      sink_(Level::warning, fmt::format("{}: not ready, waits for {}: the other axes begin without it",
                                        axis.name, lacks_text(axis, axis.lacks)));
}

void StateLog::add_lack(Axis& axis, const controller::CycleRecord& record) {
  axis.amplifier_output = record.amplifier_output;
  if (axis.lacks.first() != record.report.lacks.first()) {
    axis.lacks_since_s = record.time_s;
    axis.lack_is_logged = false;
  }
  axis.lacks = record.report.lacks;
  if (axis.lacks.empty()) return;
  axis.last_lacks = axis.lacks;
  if (record.time_s - axis.lacks_since_s < worth_a_line_s) return;
  if (!std::exchange(axis.lack_is_logged, true))
    sink_(Level::info, fmt::format("{}: still waits for {}", axis.name, lacks_text(axis, axis.lacks)));
}

std::string StateLog::lacks_text(const Axis& axis, controller::LackSet lacks) const {
  std::string text;
  for (const Lack lack : lacks.members()) text += (text.empty() ? "" : "; ") + lack_text(axis, lack);
  return text;
}

std::string StateLog::lack_text(const Axis& axis, Lack lack) const {
  const std::string_view what = to_string(lack);
  switch (lack) {
    case Lack::sensor_heartbeat:
    case Lack::sensor_operational:
    case Lack::sample:
      return fmt::format("{} (node {})", what, axis.sensor_node);
    case Lack::amplifier_heartbeat:
    case Lack::amplifier_operational:
    case Lack::clear:
    case Lack::amplifier_ready:
    case Lack::amplifier_rest:
    case Lack::enabled:
    case Lack::watchdog:
      return fmt::format("{} (node {})", what, axis.amplifier_node);
    case Lack::amplifier_output:
      return fmt::format("{} (node {}): it is {:.6g}, expected {:.6g} to {:.6g} {}", what,
                         axis.amplifier_node, axis.amplifier_output, axis.drive_min, axis.drive_max,
                         axis.drive_unit);
    case Lack::output:
      return fmt::format("{} (node {}): it is {:.6g} {}", what, axis.amplifier_node, axis.amplifier_output,
                         axis.drive_unit);
    case Lack::other_axes:
      break;
    case Lack::nothing:
      return std::string(what);
  }
  std::vector<std::string> late;
  for (const Axis& other : axes_)
    if (is_on_its_way(other.state)) late.push_back(other.name);
  return late.empty() ? std::string(what) : fmt::format("{}: {}", what, fmt::join(late, ", "));
}

std::string StateLog::lacks_of_first_axis() const {
  return fmt::format("{} waited for {}", axes_.front().name,
                     lacks_text(axes_.front(), axes_.front().last_lacks));
}

}  // namespace hystcan::app
