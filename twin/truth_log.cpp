#include "twin/truth_log.h"

#include <fmt/format.h>

#include <cerrno>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace hystcan::twin {

TruthLog::TruthLog(const std::filesystem::path& file, std::vector<std::string> axis_names)
    : path_(file), axis_names_(std::move(axis_names)), file_(std::fopen(file.c_str(), "w")) {
  if (file_ == nullptr)
    throw std::runtime_error(
        fmt::format("{}: cannot be written: {}", file.string(), std::generic_category().message(errno)));
  std::fputs(
      "# setpoint and drive in the axis's drive unit; time of CLOCK_MONOTONIC, or virtual\n"
      "time_s,axis,sync_counter,setpoint,drive,hysteresis_um,position_um,measured_um\n",
      file_);
}

TruthLog::~TruthLog() { close(); }

void TruthLog::write(const Truth& truth) {
  if (file_ == nullptr || error_ != 0) return;
  fmt::memory_buffer line;
  fmt::format_to(std::back_inserter(line), "{:.9f},{},{},{:.6f},{:.9f},{:.9f},{:.9f},{:.9f}\n",
                 can::seconds(truth.time.time_since_epoch()), axis_names_[truth.axis], truth.sync_counter,
                 truth.setpoint, truth.drive, truth.hysteresis_um, truth.position_um, truth.measured_um);
  if (std::fwrite(line.data(), 1, line.size(), file_) != line.size()) error_ = errno;
}

std::string TruthLog::close() {
  if (file_ != nullptr && std::fclose(std::exchange(file_, nullptr)) != 0 && error_ == 0) error_ = errno;
  if (error_ == 0) return {};
  return fmt::format("{}: cannot be written: {}; later rows are lost", path_.string(),
                     std::generic_category().message(error_));
}

}  // namespace hystcan::twin
