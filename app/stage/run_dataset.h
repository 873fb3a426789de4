// A recorded run as a dataset: the cycles in which one axis is driven.
//
//   time_s   of SYNC(n), as in the run
//   input    drive of the command that answered SYNC(n-1): in force from SYNC(n) until SYNC(n+1)
//   output   position at SYNC(n)
//
// This is the timing of controller/excitation_dataset.h, so that a delay means the same for both. The memory depends on
// every drive. The dataset is therefore the longest stretch without an interruption: the axis is initialising, ready or
// tracking, and no cycle is lost. It begins where the drive first moves, because the amplifier may not be enabled before.
// Cycles without a sample are left out.
#pragma once

#include <filesystem>
#include <string>

#include "identification/dataset.h"
#include "runs/run.h"

namespace hystcan::app {

/// Whether it is a folder or a CSV of cycles, and not a dataset.
bool is_recorded_run(const std::filesystem::path& file);

/// Notes on standard error which stretch it is. `axis`: empty: the only one. Throws Error with the name of the run
/// if it is none, if it has no such axis, if the axis is not driven in `span`, or if the stretch has more than
/// config::most_dataset_rows.
identification::Dataset load_run(const std::filesystem::path& run, const std::string& axis,
                                 const runs::TimeSpan& span);

}  // namespace hystcan::app
