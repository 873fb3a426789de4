#include "runs/folder_limit.h"

#include <algorithm>
#include <system_error>

#include "base/error.h"
#include "runs/part_converter.h"
#include "runs/run_folder.h"
#include "runs/run_info.h"

namespace hystcan::runs {
namespace {

using Path = std::filesystem::path;

std::uintmax_t bytes_below(const Path& folder) {
  std::uintmax_t bytes = 0;
  std::error_code error;
  std::filesystem::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code gone;
    const std::uintmax_t size = entry->is_regular_file(gone) ? entry->file_size(gone) : 0;
    if (!gone) bytes += size;
  }
  return bytes;
}

bool had_a_fault(const Path& run) {
  try {
    return std::ranges::any_of(read_run_info(run).axes,
                               [](const RunAxis& axis) { return !axis.summary.faults.empty(); });
  } catch (const Error&) {
    return true;  // nobody knows
  }
}

/// Runs that may go, in the order in which they go.
std::vector<Path> dispensable(const Path& folder, const Path& current) {
  std::vector<Path> runs = runs_in(folder);
  std::erase_if(runs, [&](const Path& run) {
    return run.filename() == current.filename() || exists(run / "keep") || is_being_recorded(run);
  });
  std::stable_partition(runs.begin(), runs.end(), [](const Path& run) { return !had_a_fault(run); });
  return runs;
}

/// The CSVs of the run that is being recorded that may go: all but the last.
std::vector<Path> dispensable_parts(const Path& current) {
  std::vector<Path> parts = exists(current / "keep") ? std::vector<Path>() : parts_of(current);
  if (!parts.empty()) parts.pop_back();
  return parts;
}

}  // namespace

std::uintmax_t bytes_of_runs(const Path& folder) {
  std::uintmax_t bytes = 0;
  for (const Path& run : runs_in(folder)) bytes += bytes_below(run);
  return bytes;
}

LimitOutcome keep_limit(const Path& folder, const Path& current, std::uintmax_t most_bytes) {
  LimitOutcome outcome{.removed = {}, .bytes = bytes_of_runs(folder)};
  std::error_code ignored;
  if (outcome.bytes <= most_bytes) return outcome;
  for (const Path& run : dispensable(folder, current)) {
    if (outcome.bytes <= most_bytes) return outcome;
    outcome.bytes -= std::min(outcome.bytes, bytes_below(run));
    std::filesystem::remove_all(run, ignored);
    outcome.removed.push_back(run.filename().string());
  }
  for (const Path& part : dispensable_parts(current)) {
    if (outcome.bytes <= most_bytes) return outcome;
    for (const Path& file : {part, hdf5_of(part)}) {
      const std::uintmax_t size = std::filesystem::file_size(file, ignored);
      if (std::filesystem::remove(file, ignored)) outcome.bytes -= std::min(outcome.bytes, size);
    }
    outcome.removed.push_back(current.filename().string() + "/" + part.stem().string());
  }
  outcome.is_kept = outcome.bytes <= most_bytes;
  return outcome;
}

}  // namespace hystcan::runs
