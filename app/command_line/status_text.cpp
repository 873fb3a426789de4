#include "app/command_line/status_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/text.h"

namespace hystcan::app {
namespace {

/// "recording runs/run_...: 120000 rows, 25.1 MB".
std::string recording_text(const nlohmann::json& recording) {
  std::string text = fmt::format(
      "{} {}: {}, {:.1f} MB", recording.at("on") == true ? "recording" : "recorded",
      recording.at("run").get<std::string>(), counted(recording.at("rows").get<std::uint64_t>(), "row"),
      1e-6 * recording.at("bytes").get<double>());
  if (const auto lost = recording.at("rows_lost").get<std::uint64_t>(); lost > 0)
    text += fmt::format(", {} lost", counted(lost, "row"));
  if (recording.contains("failure")) text += "; it ended: " + recording.at("failure").get<std::string>();
  return text;
}

std::string cycles_text(const nlohmann::json& status) {
  return fmt::format("{:.1f} s, {:.2f} s ago: {}, {} missed, {} missing, {} late",
                     status.at("time_s").get<double>(), status.at("age_s").get<double>(),
                     counted(status.at("cycles").get<std::uint64_t>(), "cycle"),
                     status.at("missed_cycles").get<std::uint64_t>(),
                     counted(status.at("missing_samples").get<std::uint64_t>(), "sample"),
                     status.at("late_samples").get<std::uint64_t>());
}

std::string remark_on(const nlohmann::json& axis) {
  if (axis.at("state") == "faulted")
    return fmt::format("{} at {:.3f} s; {}", axis.at("fault").get<std::string>(),
                       axis.at("fault_time_s").get<double>(), axis.at("remedy").get<std::string>());
  if (axis.contains("waits_for_all"))
    return fmt::format("waits for {}",
                       fmt::join(axis.at("waits_for_all").get<std::vector<std::string>>(), "; "));
  std::string remark = axis.value("arrival", "");
  if (const std::string limits = axis.at("limits"); !limits.empty()) remark += " limited by " + limits;
  return remark;
}

void add_axes(const nlohmann::json& status, std::vector<std::string>& lines) {
  const auto row = [&](const auto& name, const auto& state, const auto& reference, const auto& position,
                       const auto& error, const auto& drive, const auto& output, const auto& remark) {
    lines.push_back(fmt::format("{:<8} {:<13} {:>13} {:>12} {:>12} {:>10} {:>10}  {}", name, state, reference,
                                position, error, drive, output, remark));
  };
  row("axis", "state", "reference um", "position um", "error um", "drive", "output", "");
  for (const nlohmann::json& axis : status.at("axes"))
    row(axis.at("name").get<std::string>(), axis.at("state").get<std::string>(),
        four_decimals(axis.value("reference_um", nlohmann::json())), four_decimals(axis.at("position_um")),
        four_decimals(axis.value("error_um", nlohmann::json())), four_decimals(axis.at("drive")),
        four_decimals(axis.value("amplifier_output", nlohmann::json())), remark_on(axis));
}

/// "bus vcan0: up, 4000 frames/s, 38.2 %".
std::string bus_text(const nlohmann::json& bus) {
  std::string text =
      fmt::format("bus {}: {}", bus.at("interface").get<std::string>(), bus.at("state").get<std::string>());
  if (bus.at("frames_per_s").is_number())
    text += fmt::format(", {:.0f} frames/s", bus.at("frames_per_s").get<double>());
  if (bus.at("load_percent").is_number())
    text += fmt::format(", load {:.1f} %", bus.at("load_percent").get<double>());
  return text;
}

std::string timing_text(const nlohmann::json& timing) {
  return fmt::format(
      "last cycle: period {:.1f} us, SYNC late {:.1f} us, sample to command {:.1f} us, computed in {:.1f} us",
      timing.at("period_us").get<double>(), timing.at("lateness_us").get<double>(),
      timing.at("turnaround_us").get<double>(), timing.at("execution_us").get<double>());
}

/// An axis that waits for a node says so in its row.
std::string nodes_text(const nlohmann::json& status) {
  if (!status.contains("last_event")) return "nodes: no event yet";
  const nlohmann::json& event = status.at("last_event");
  return fmt::format("nodes: {}, {:.1f} s", event.at("text").get<std::string>(),
                     event.at("time_s").get<double>());
}

}  // namespace

std::string four_decimals(const nlohmann::json& value) {
  return value.is_number() ? fmt::format("{:.4f}", value.get<double>()) : "-";
}

std::vector<std::string> status_lines(const nlohmann::json& status) {
  std::vector<std::string> lines{cycles_text(status)};
  if (const nlohmann::json recording = status.value("recording", nlohmann::json::object());
      recording.contains("run"))
    lines.push_back(recording_text(recording));
  add_axes(status, lines);
  return lines;
}

std::vector<std::string> status_screen(const nlohmann::json& status, const nlohmann::json& bus,
                                       const std::string& trouble) {
  std::vector<std::string> lines;
  if (!trouble.empty()) lines.push_back(trouble);
  if (!bus.is_null()) lines.push_back(bus_text(bus));
  if (status.is_null()) return lines;
  lines.push_back(timing_text(status.at("timing")));
  lines.push_back(nodes_text(status));
  for (std::string& line : status_lines(status)) lines.push_back(std::move(line));
  return lines;
}

}  // namespace hystcan::app
