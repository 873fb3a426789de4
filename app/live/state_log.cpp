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
                     .nodes = fmt::format("amplifier node {} and sensor node {}", axis.wire.amplifier_node,
                                          axis.wire.sensor_node)});
}

void StateLog::add(const controller::CycleRecord& record) {
  Axis& axis = axes_[record.axis];
  events_.add(axis.name, record);
  if (axis.state != record.report.state) add_state(axis, record);
  add_lack(axis, record);
}

void StateLog::add_state(Axis& axis, const controller::CycleRecord& record) {
  const controller::AxisReport& report = record.report;
  axis.state = report.state;
  if (report.state == AxisState::faulted)
    sink_(Level::error, fmt::format("{}: faulted at {:.3f} s: {}; {}", axis.name, record.time_s,
                                    to_string(report.cause), remedy(report.cause)));
  else if (report.state == AxisState::waiting)
    sink_(Level::info, fmt::format("{}: waiting for {}", axis.name, axis.nodes));
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
                                        axis.name, to_string(axis.lacks)));
}

void StateLog::add_lack(Axis& axis, const controller::CycleRecord& record) {
  if (axis.lacks != record.report.lacks) {
    axis.lacks = record.report.lacks;
    axis.lacks_since_s = record.time_s;
    axis.lack_is_logged = false;
  }
  if (axis.lacks != Lack::nothing) axis.last_lack = axis.lacks;
  if (axis.lacks == Lack::nothing || record.time_s - axis.lacks_since_s < worth_a_line_s) return;
  if (!std::exchange(axis.lack_is_logged, true))
    sink_(Level::info, fmt::format("{}: still waits for {}", axis.name, to_string(axis.lacks)));
}

std::string StateLog::first_lack() const {
  return fmt::format("{} waited for {}", axes_.front().name, to_string(axes_.front().last_lack));
}

}  // namespace hystcan::app
