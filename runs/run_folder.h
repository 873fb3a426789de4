// Handles the folder that contains all runs: creates the folder of a new run, finds runs and their parts, and
// limits the total size.
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

/// Returns the description of a run with this configuration, still without times and results. `settings` are
/// the configuration keys and the values in force.
RunInfo describe(const config::Config& config, const std::vector<config::Setting>& settings,
                 const std::string& command);

/// Locks the folder of a run. While the returned descriptor is open, is_being_recorded() is true for the run,
/// in all programs.
Descriptor lock_run(const std::filesystem::path& run);
bool is_being_recorded(const std::filesystem::path& run);

/// Creates the folder of a run that starts at `now`, in `folder`. Copies the configuration and all files
/// named in the settings of `info` into the new folder. Throws std::system_error or
/// std::filesystem::filesystem_error.
std::filesystem::path make_run_folder(const std::filesystem::path& folder,
                                      const std::filesystem::path& config_file, const RunInfo& info,
                                      std::chrono::system_clock::time_point now);

/// Returns the CSVs of a run in order: cycles_0001.csv, ...
std::vector<std::filesystem::path> parts_of(const std::filesystem::path& run);
/// Returns the file name of part `number`. Numbers count from 1: part_name("cycles", 1, ".csv") is
/// cycles_0001.csv.
std::string part_name(const char* what, unsigned number, const char* ending);

/// Returns the paths of the runs in `folder`, oldest first. Throws Error if the folder can't be read.
std::vector<std::filesystem::path> runs_in(const std::filesystem::path& folder);

struct LimitOutcome {
  std::vector<std::string> removed;  ///< names of removed runs, and of removed parts of the current run
  std::uintmax_t bytes = 0;          ///< size of the folder after the removal
  bool is_kept = true;  ///< true: the folder is within the limit; false: the folder is still too large, but
                        ///< nothing more may be removed
};

/// Returns the total size of all runs in `folder`. Ignores files that disappear during the call.
std::uintmax_t bytes_of_runs(const std::filesystem::path& folder);

/// Keeps the total size of the runs in `folder` at or below `most_bytes`. Removes in this order:
///
///   1. the oldest run without a fault
///   2. the oldest run with a fault
///   3. the oldest parts of the run that is being recorded, but never the part that is being written
///
/// A run is removed as a whole. A run that contains a file named `keep` is never removed, and neither is a
/// run that another program is recording. Files that do not belong to a run are never removed.
///
/// `current` is the run in `folder` that this program is recording.
LimitOutcome keep_limit(const std::filesystem::path& folder, const std::filesystem::path& current,
                        std::uintmax_t most_bytes);

}  // namespace hystcan::runs
