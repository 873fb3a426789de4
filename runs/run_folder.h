// The folder of runs: creates the folder of a new run, finds runs and their parts, limits the total size.
#pragma once

#include <chrono>
#include <cstdint>
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

/// Formats a time as 2026-11-23T09:20:00.123Z.
std::string iso_text(std::chrono::system_clock::time_point time);

/// Returns the description of a run with this configuration, without times and outcome. `settings`: the keys
/// in force.
RunInfo describe(const config::Config& config, const std::vector<config::Setting>& settings,
                 const std::string& command);

/// Locks the run: while the result is open, other programs treat the run as being recorded.
Descriptor lock_run(const std::filesystem::path& run);
bool is_being_recorded(const std::filesystem::path& run);

/// Creates the folder for a run that starts now, with copies of the configuration and of all files named by
/// the settings in `info`. Throws std::system_error or std::filesystem::filesystem_error.
std::filesystem::path make_run_folder(const std::filesystem::path& folder,
                                      const std::filesystem::path& config_file, const RunInfo& info,
                                      std::chrono::system_clock::time_point now);

/// Returns the parts of a run in order: cycles_0001.csv, ...
std::vector<std::filesystem::path> parts_of(const std::filesystem::path& run);
/// Returns the file name of part `number`, from 1: part_name("cycles", 1, ".csv").
std::string part_name(const char* what, unsigned number, const char* ending);

/// Returns the names of the runs in `folder`, oldest first. Throws Error if the folder can't be read.
std::vector<std::filesystem::path> runs_in(const std::filesystem::path& folder);

struct LimitOutcome {
  std::vector<std::string> removed;  ///< names of removed runs, and of removed parts of `current`
  std::uintmax_t bytes = 0;          ///< remaining size of the folder
  bool is_kept = true;               ///< false: nothing more may be removed, and the folder is still too
                                     ///< large
};

/// Returns the size of all runs in the folder, without files that disappear during the call.
std::uintmax_t bytes_of_runs(const std::filesystem::path& folder);

/// Keeps a folder of runs below a size. Removes in this order:
///
///   1. the oldest run without a fault
///   2. the oldest run with a fault
///   3. the oldest parts of the run that is being recorded, but never the part that is being written
///
/// A run is removed as a whole. A run that contains a file named `keep`, and a run that another program is
/// recording, are never removed. Only runs are removed.
///
/// `current`: the run in `folder` that this program is recording.
LimitOutcome keep_limit(const std::filesystem::path& folder, const std::filesystem::path& current,
                        std::uintmax_t most_bytes);

}  // namespace hystcan::runs
