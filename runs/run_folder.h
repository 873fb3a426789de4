// The folder of runs: making the folder of a new run, finding runs and their parts, keeping all below a size.
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

/// 2026-11-23T09:20:00.123Z
std::string iso_text(std::chrono::system_clock::time_point time);

/// What a run of this configuration says of itself, but for time and outcome. `settings`: those in force.
RunInfo describe(const config::Config& config, const std::vector<config::Setting>& settings,
                 const std::string& command);

/// As long as the result is open, other programs know that the run is being recorded.
Descriptor lock_run(const std::filesystem::path& run);
bool is_being_recorded(const std::filesystem::path& run);

/// Makes the folder for a run that starts now, with copies of the configuration and of all files that
/// `info`'s settings name. Throws std::system_error or std::filesystem::filesystem_error.
std::filesystem::path make_run_folder(const std::filesystem::path& folder,
                                      const std::filesystem::path& config_file, const RunInfo& info,
                                      std::chrono::system_clock::time_point now);

/// The parts of a run in order: cycles_0001.csv, ...
std::vector<std::filesystem::path> parts_of(const std::filesystem::path& run);
/// The file of part `number`, from 1: part_name("cycles", 1, ".csv").
std::string part_name(const char* what, unsigned number, const char* ending);

/// Names of the folders of runs in `folder`, oldest first. Throws Error if it cannot be read.
std::vector<std::filesystem::path> runs_in(const std::filesystem::path& folder);

struct LimitOutcome {
  std::vector<std::string> removed;  ///< names of runs, and of parts of `current`
  std::uintmax_t bytes = 0;          ///< that are left
  bool is_kept = true;               ///< false: nothing more may be removed, and the folder is still above
};

/// Bytes of all runs of the folder. What vanishes meanwhile does not count.
std::uintmax_t bytes_of_runs(const std::filesystem::path& folder);

/// Keeps a folder of runs below a size. What goes first:
///
///   1. the oldest run without a fault
///   2. the oldest run with a fault
///   3. the oldest parts of the run that is being recorded, but never the part that is being written
///
/// A run is removed as a whole. One that holds a file named `keep`, and one that another program records,
/// is never removed. Nothing but runs is ever removed.
///
/// `current`: the run that is being recorded by this program, in `folder`.
LimitOutcome keep_limit(const std::filesystem::path& folder, const std::filesystem::path& current,
                        std::uintmax_t most_bytes);

}  // namespace hystcan::runs
