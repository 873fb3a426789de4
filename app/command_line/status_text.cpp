#include "app/command_line/status_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <string>
#include <vector>

#include "app/live/report.h"
#include "base/text.h"

namespace hystcan::app {
namespace {

/// Returns a line such as "recording runs/run_...: 120000 rows, 25.1 MB".
std::string recording_text(const runs::RunWriter::Status& recording) {
  std::string text = fmt::format("{} {}: {}, {:.1f} MB", recording.is_recording ? "recording" : "recorded",
                                 recording.run.string(), counted(recording.rows, "row"),
                                 1e-6 * static_cast<double>(recording.bytes));
  if (recording.rows_lost > 0) text += fmt::format(", {} lost", counted(recording.rows_lost, "row"));
  if (!recording.failure.empty()) text += "; it ended: " + recording.failure;
  return text;
}

std::string cycles_text(const StatusAnswer& status) {
  return fmt::format("at {:.1f} s, {:.2f} s ago: {}", status.time_s, status.age_s, describe(status.counters));
}

std::string remark_on(const AxisAnswer& axis) {
  if (axis.state == controller::AxisState::faulted)
    return fmt::format("{} at {:.3f} s; {}", axis.fault, axis.fault_time_s, axis.remedy);
  if (!axis.waits_for_all.empty()) return fmt::format("waits for {}", fmt::join(axis.waits_for_all, "; "));
  std::string remark(axis.tracks() ? to_string(axis.arrival) : "");
  if (!axis.limits.empty()) remark += " limited by " + axis.limits;
  return remark;
}

void add_axes(const StatusAnswer& status, std::vector<std::string>& lines) {
  const auto row = [&](const auto& name, const auto& state, const auto& reference, const auto& position,
                       const auto& error, const auto& drive, const auto& output, const auto& remark) {
    lines.push_back(fmt::format("{:<8} {:<13} {:>13} {:>12} {:>12} {:>10} {:>10}  {}", name, state, reference,
                                position, error, drive, output, remark));
  };
  row("axis", "state", "reference um", "position um", "error um", "drive", "output", "");
  for (const AxisAnswer& axis : status.axes)
    row(axis.name, to_string(axis.state), four_decimals(axis.reference_um), four_decimals(axis.position_um),
        four_decimals(axis.error_um), four_decimals(axis.drive), four_decimals(axis.amplifier_output),
        remark_on(axis));
}

/// Returns a line such as "bus vcan0: up, 4000 frames/s, load 38.2 %".
std::string bus_text(const BusReport& bus) {
  std::string text = fmt::format("bus {}: {}", bus.interface, bus.state);
  if (!std::isnan(bus.frames_per_s)) text += fmt::format(", {:.0f} frames/s", bus.frames_per_s);
  if (!std::isnan(bus.load_percent)) text += fmt::format(", load {:.1f} %", bus.load_percent);
  return text;
}

std::string timing_text(const TimingAnswer& timing) {
  return fmt::format(
      "last cycle: period {:.1f} us, SYNC late {:.1f} us, sample to command {:.1f} us, computed in {:.1f} us",
      timing.period_us, timing.lateness_us, timing.turnaround_us, timing.execution_us);
}

/// Returns a line with the last event of any node. Whether an axis still waits for a node is shown in the
/// line of the axis.
std::string nodes_text(const std::optional<LastEvent>& event) {
  return event ? fmt::format("nodes: {}, {:.1f} s", event->text, event->time_s) : "nodes: no event yet";
}

}  // namespace

std::string four_decimals(double value) { return std::isnan(value) ? "-" : fmt::format("{:.4f}", value); }

std::vector<std::string> status_lines(const StatusAnswer& status) {
  std::vector<std::string> lines{cycles_text(status)};
  if (!status.recording.run.empty()) lines.push_back(recording_text(status.recording));
  add_axes(status, lines);
  return lines;
}

std::vector<std::string> status_screen(const std::optional<StatusAnswer>& status,
                                       const std::optional<BusReport>& bus, const std::string& error) {
  std::vector<std::string> lines;
  if (!error.empty()) lines.push_back(error);
  if (bus) lines.push_back(bus_text(*bus));
  if (!status) return lines;
  lines.push_back(timing_text(status->timing));
  lines.push_back(nodes_text(status->last_event));
  for (std::string& line : status_lines(*status)) lines.push_back(std::move(line));
  return lines;
}

}  // namespace hystcan::app
