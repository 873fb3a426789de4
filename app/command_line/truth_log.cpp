#include "app/command_line/truth_log.h"

#include <fmt/format.h>

#include <utility>

namespace hystcan::app {

TruthLog::TruthLog(const std::filesystem::path& file, std::vector<std::string> axis_names)
    : axis_names_(std::move(axis_names)), rows_(file, AppendFile::Existing::replace) {
  rows_.add(
      "# setpoint and drive are in the drive unit of the axis; time is CLOCK_MONOTONIC or virtual\n"
      "time_s,axis,sync_counter,setpoint,drive,hysteresis_um,position_um,measured_um\n");
}

void TruthLog::write(const twin::Truth& truth) {
  rows_.add(fmt::format("{:.9f},{},{},{:.6f},{:.9f},{:.9f},{:.9f},{:.9f}\n",
                        can::seconds(truth.time.time_since_epoch()), axis_names_[truth.axis],
                        truth.sync_counter, truth.setpoint, truth.drive, truth.hysteresis_um,
                        truth.position_um, truth.measured_um));
}

std::optional<std::string> TruthLog::close() {
  rows_.close();
  if (!rows_.error()) return std::nullopt;
  return rows_.error_text() + "; later rows are lost";
}

}  // namespace hystcan::app
