#include "app/live/state_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace hystcan::app {

can::BusHealthLog::Sink bus_log_sink() {
  return [](can::BusHealthLog::Level level, const std::string& line) {
    using Level = can::BusHealthLog::Level;
    spdlog::log(level == Level::error     ? spdlog::level::err
                : level == Level::warning ? spdlog::level::warn
                                          : spdlog::level::info,
                line);
  };
}

BusClosing closing_of(const controller::Controller& controller, const EventLog& events) {
  BusClosing closing{.events = events.lines(),
                     .events_truncated = events.truncated(),
                     .bus = can::report_of(controller.bus(), 0.0),
                     .rejected = controller.rejected()};
  std::ranges::copy(controller.node_notes(), std::back_inserter(closing.events));
  for (std::size_t i = 0; i < controller.axis_count(); ++i) {
    const controller::WiredAxis& axis = controller.wired_axis(i);
    if (!axis.setpoint_receiver) continue;
    const std::string text = describe(axis.setpoint_receiver->counters());
    if (!text.empty()) closing.events.push_back(axis.wire.name + ": " + text);
  }
  return closing;
}

namespace {

using controller::ArmingBlock;
using controller::AxisState;
using Level = can::BusHealthLog::Level;

constexpr double between_lines_s = 1.0;

std::string at(const std::string& axes, double time_s, const controller::NodeEvent& event) {
  return fmt::format("{}: at {:.3f} s {}", axes, time_s, describe(event));
}

Level level_of(const controller::NodeEvent& event) {
  return is_all_clear(event) ? Level::info : Level::warning;
}

/// If an axis waits longer than this time for a condition without which it cannot track, for example a
/// heartbeat, the log gets a line. Shorter waits are normal during a start.
constexpr double worth_a_line_s = 2.0;

bool is_on_its_way(AxisState state) {
  return state == AxisState::waiting || state == AxisState::initialising;
}

}  // namespace

void EventLog::add(const std::string& axes, const controller::CycleRecord& record) {
  if (record.event) {
    const auto known = std::ranges::find_if(kinds_, [&](const Kind& kind) {
      return kind.axis_index == record.axis && are_of_one_kind(kind.event, *record.event);
    });
    if (known != kinds_.end()) {
      count(*known, record);
    } else if (kinds_.size() < most_kinds) {
      kinds_.push_back({.axes = axes,
                        .axis_index = record.axis,
                        .event = *record.event,
                        .first_s = record.time_s,
                        .line_s = record.time_s - between_lines_s});
      count(kinds_.back(), record);
    } else if (std::exchange(truncated_, truncated_ + record.event->times) == 0) {
      sink_(Level::warning, fmt::format("{}; more than {} kinds of events, so further kinds are only counted",
                                        at(axes, record.time_s, *record.event), most_kinds));
    }
  }
  log_pending(record.time_s);
}

void EventLog::count(Kind& kind, const controller::CycleRecord& record) {
  kind.last_s = record.time_s;
  kind.total += record.event->times;
  const bool is_new = kind.pending == 0 && record.time_s - kind.line_s >= between_lines_s;
  kind.pending += record.event->times;
  if (!is_new) return;
  kind.line_s = record.time_s;
  --kind.pending;
  sink_(level_of(kind.event), at(kind.axes, record.time_s, *record.event));
}

void EventLog::log_pending(double time_s) {
  for (Kind& kind : kinds_) {
    if (kind.pending == 0 || time_s - kind.line_s < between_lines_s) continue;
    sink_(level_of(kind.event),
          fmt::format("{}: {}, {} more times in {:.1f} s", kind.axes, describe(kind.event),
                      std::exchange(kind.pending, 0), time_s - kind.line_s));
    kind.line_s = time_s;
  }
}

std::vector<std::string> EventLog::lines() const {
  std::vector<std::string> lines;
  lines.reserve(kinds_.size() + 1);
  for (const Kind& kind : kinds_) {
    lines.push_back(at(kind.axes, kind.first_s, kind.event));
    if (kind.total > 1) lines.back() += fmt::format(", {} times until {:.3f} s", kind.total, kind.last_s);
  }
  return lines;
}

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
  if (record.event && !is_told_by_another(record))
    events_.add(concerned(axis, *record.event), record);
  else
    events_.log_pending(record.time_s);
  if (const auto& after_s = record.report.watchdog_tripped_after_s)
    sink_(Level::info,
          fmt::format("{}: watchdog of the amplifier (node {}) verified: tripped after {:.0f} ms", axis.name,
                      axis.amplifier_node, 1e3 * *after_s));
  if (axis.state != record.report.state) add_state(axis, record);
  add_block(axis, record);
}

bool StateLog::is_told_by_another(const controller::CycleRecord& record) {
  constexpr double at_once_s = 0.1;
  const controller::NodeEvent& event = *record.event;
  if (event.kind != controller::NodeEvent::Kind::another_controller) {
    const auto first = std::ranges::find_if(axes_, [&](const Axis& axis) { return axis.has(event.node); });
    return static_cast<std::size_t>(first - axes_.begin()) < record.axis;
  }
  const auto told = std::exchange(foreign_, Told{record.axis, event.frame, record.time_s});
  return told && told->axis != record.axis && told->frame == event.frame &&
         record.time_s - told->time_s < at_once_s;
}

/// Returns the names of the axes that the event concerns. A second controller on the bus concerns every axis.
std::string StateLog::concerned(const Axis& axis, const controller::NodeEvent& event) const {
  const bool is_of_all = event.kind == controller::NodeEvent::Kind::another_controller;
  std::vector<std::string> names;
  for (const Axis& each : axes_)
    if (is_of_all || each.has(event.node)) names.push_back(each.name);
  return names.empty() ? axis.name : fmt::format("{}", fmt::join(names, ", "));
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
  const bool is_first = !has_any_tracked();
  axis.has_tracked = true;
  if (is_first) add_missing_axes();
}

/// Logs a warning for each axis that is not ready when the first axis begins to track. An axis whose state is
/// `ready` here gets no warning: it may begin in the same cycle, because its record is processed later.
void StateLog::add_missing_axes() {
  for (const Axis& axis : axes_)
    if (is_on_its_way(axis.state))
      sink_(Level::warning, fmt::format("{}: not ready, waits for {}; the other axes start without it",
                                        axis.name, blocks_text(axis, axis.blocks)));
}

void StateLog::add_block(Axis& axis, const controller::CycleRecord& record) {
  axis.amplifier_output = record.amplifier_output;
  if (axis.blocks.first() != record.report.arming_blocks.first()) {
    axis.blocked_since_s = record.time_s;
    axis.block_is_logged = false;
  }
  axis.blocks = record.report.arming_blocks;
  if (axis.blocks.empty()) return;
  axis.last_blocks = axis.blocks;
  if (record.time_s - axis.blocked_since_s < worth_a_line_s) return;
  if (!std::exchange(axis.block_is_logged, true))
    sink_(Level::info, fmt::format("{}: still waits for {}", axis.name, blocks_text(axis, axis.blocks)));
}

std::string StateLog::blocks_text(const Axis& axis, controller::ArmingBlocks blocks) const {
  std::string text;
  for (const ArmingBlock block : blocks.members())
    text += (text.empty() ? "" : "; ") + block_text(axis, block);
  return text;
}

std::string StateLog::block_text(const Axis& axis, ArmingBlock block) const {
  const std::string_view what = to_string(block);
  switch (block) {
    case ArmingBlock::sensor_heartbeat:
    case ArmingBlock::sensor_operational:
    case ArmingBlock::sample:
      return fmt::format("{} (node {})", what, axis.sensor_node);
    case ArmingBlock::amplifier_heartbeat:
    case ArmingBlock::amplifier_operational:
    case ArmingBlock::clear:
    case ArmingBlock::amplifier_ready:
    case ArmingBlock::amplifier_rest:
    case ArmingBlock::enabled:
    case ArmingBlock::watchdog:
      return fmt::format("{} (node {})", what, axis.amplifier_node);
    case ArmingBlock::amplifier_output:
      return fmt::format("{} (node {}): the output is {:.6g}, expected {:.6g} to {:.6g} {}", what,
                         axis.amplifier_node, axis.amplifier_output, axis.drive_min, axis.drive_max,
                         axis.drive_unit);
    case ArmingBlock::output:
      return fmt::format(
          "{} (node {}): the output is {:.6g} {} and differs from the commanded drive; "
          "check the amplifier's interlock and supply",
          what, axis.amplifier_node, axis.amplifier_output, axis.drive_unit);
    case ArmingBlock::other_axes:
      break;
    case ArmingBlock::nothing:
      return std::string(what);
  }
  std::vector<std::string> late;
  for (const Axis& other : axes_)
    if (is_on_its_way(other.state)) late.push_back(other.name);
  return late.empty() ? std::string(what) : fmt::format("{}: {}", what, fmt::join(late, ", "));
}

std::string StateLog::blocks_of(std::size_t axis) const {
  return fmt::format("{} waited for {}", axes_[axis].name, blocks_text(axes_[axis], axes_[axis].last_blocks));
}

}  // namespace hystcan::app
