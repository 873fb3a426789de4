// Keeps a folder of runs below a size. What goes first:
//
//   1. the oldest run without a fault
//   2. the oldest run with a fault
//   3. the oldest parts of the run that is being recorded, but never the part that is being written
//
// A run is removed as a whole. One that holds a file named `keep`, and one that another program records, is never
// removed. Nothing but runs is ever removed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace hystcan::runs {

struct LimitOutcome {
  std::vector<std::string> removed;  ///< names of runs, and of parts of `current`
  std::uintmax_t bytes = 0;          ///< that are left
  bool is_kept = true;               ///< false: nothing more may be removed, and the folder is still above
};

/// Bytes of all runs of the folder. What vanishes meanwhile does not count.
std::uintmax_t bytes_of_runs(const std::filesystem::path& folder);

/// `current`: the run that is being recorded by this program, in `folder`.
LimitOutcome keep_limit(const std::filesystem::path& folder, const std::filesystem::path& current,
                        std::uintmax_t most_bytes);

}  // namespace hystcan::runs
