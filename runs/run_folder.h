// The folder of a new run, with all that describes it.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "config/document/setting.h"
#include "config/schema/config.h"
#include "runs/run_info.h"

namespace hystcan::runs {

using UtcNow = std::function<std::chrono::system_clock::time_point()>;

/// 2026-11-23T09:20:00.123Z
std::string iso_text(std::chrono::system_clock::time_point time);

/// What a run of this configuration says of itself, but for time and outcome. `settings`: those in force.
RunInfo describe(const config::Config& config, const std::vector<config::Setting>& settings,
                 const std::string& command);

/// As long as it is open, other programs know that the run is being recorded.
class RunLock {
 public:
  explicit RunLock(const std::filesystem::path& run);

 private:
  Descriptor folder_;
};
bool is_being_recorded(const std::filesystem::path& run);

/// Makes the folder for a run that starts now, with copies of the configuration and of all files that `info`'s settings
/// name. Throws std::system_error or std::filesystem::filesystem_error.
std::filesystem::path make_run_folder(const std::filesystem::path& folder,
                                      const std::filesystem::path& config_file, const RunInfo& info,
                                      std::chrono::system_clock::time_point now);

}  // namespace hystcan::runs
