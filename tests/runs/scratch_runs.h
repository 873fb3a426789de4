// A folder for runs that is removed after the test, and records to store in them.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "can/bus_health_log.h"
#include "config/schema/settings.h"
#include "runs/recorder.h"
#include "runs/run.h"
#include "runs/run_folder.h"
#include "tests/support/scratch.h"

namespace hystcan::runs {

using RecordedRun = Run;  // in a test, Run is a member of testing::Test

class ScratchRuns : public testing::Test {
 protected:
  ScratchRuns() {
    config = config::load(std::filesystem::path(HYSTCAN_SOURCE_DIR) / "config" / "piezo.toml");
    config.record.folder = folder / "runs";
  }

  Recorder make() {
    return {config, describe(config, config::settings(config.file), "test"),
            [this](can::BusHealthLog::Level, const std::string& line) {
              const std::scoped_lock lock(mutex);
              log.push_back(line);
            }};
  }
  std::vector<std::string> logged() const {
    const std::scoped_lock lock(mutex);
    return log;
  }

  /// Cycle n at n ms, tracking, with an error of 0.5 um.
  static controller::CycleRecord tracked(std::uint64_t cycle, std::size_t axis = 0) {
    controller::CycleRecord record;
    record.cycle = cycle;
    record.time_s = 1e-3 * static_cast<double>(cycle);
    record.axis = axis;
    record.report.state = controller::AxisState::tracking;
    record.report.reference_um = 10.5;
    record.report.position_um = 10.0;
    record.report.drive = 0.25 * static_cast<double>(cycle);
    return record;
  }

  static std::string text_of(const std::filesystem::path& file) {
    std::ifstream stream(file);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

  const support::ScratchFolder scratch;
  const std::filesystem::path& folder = scratch.path();
  config::Config config;
  mutable std::mutex mutex;
  std::vector<std::string> log;
};

}  // namespace hystcan::runs
