// Measured datasets as input of the commands that identify: files and recorded runs, an interval of time,
// units.
//
// A recorded run is a dataset of the cycles in which one axis is driven.
//
//   time_s   of SYNC(n), as in the run
//   input    drive of the command that answered SYNC(n-1): in force from SYNC(n) until SYNC(n+1)
//   output   position at SYNC(n)
//
// This is the timing of controller/excitation_dataset.h, so that a delay means the same for both. The memory
// depends on every drive. The dataset is therefore the longest stretch without an interruption: the axis is
// initialising, ready or tracking, and no cycle is lost. It begins where the drive first moves, because the
// amplifier may not be enabled before. Cycles without a sample are left out.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/files/dataset_file.h"
#include "identification/dataset.h"
#include "runs/run.h"

namespace CLI {
class App;
}  // namespace CLI

namespace hystcan::app {

struct DatasetInput {
  std::string axis;  ///< of recorded runs; empty: the only one
  std::string input_unit, output_unit;
  std::string model_output_unit;  ///< the outputs are converted to this length; empty: as they are
  config::DatasetLayout layout;   ///< with --from and --to
};

/// Throws Error if the unit that the file states (`# input_unit = "V"`) is not `expected`. An empty
/// `file_unit` means that the file states none. `suffix` ends the message.
void require_unit(const std::filesystem::path& file, const char* name, const std::string& file_unit,
                  const std::string& expected, const char* suffix = "");

/// Between --from and --to. Throws Error if --from lies after --to.
runs::TimeSpan span_of(const DatasetInput& input);

/// --columns, --output-scale.
void add_column_options(CLI::App& command, config::DatasetLayout& layout);
/// These, --rate.
void add_layout_options(CLI::App& command, DatasetInput& input);
/// --from, --to.
void add_interval_options(CLI::App& command, DatasetInput& input);
/// All of them, --input-unit, --output-unit.
void add_dataset_options(CLI::App& command, DatasetInput& input);

/// Throws Error if an axis is named and none of the files is a recorded run, which has axes.
void require_run_for_axis(const std::vector<std::filesystem::path>& files, const DatasetInput& input,
                          const char* otherwise = "");

/// Notes on standard error what a crash has cut at its end. Throws Error if it is no run.
runs::Run open_run(const std::filesystem::path& run);

/// Notes on standard error which stretch it is. `axis`: empty: the only one. Throws Error with the name of
/// the run if it is none, if it has no such axis, if the axis is not driven in `span`, or if the stretch has
/// more than config::most_dataset_rows.
identification::Dataset load_run(const std::filesystem::path& run, const std::string& axis,
                                 const runs::TimeSpan& span);

/// Loads a dataset and notes on standard error which columns it took by likeness, and whether the last row
/// was left out.
identification::Dataset load_noting(const std::filesystem::path& file, const config::DatasetLayout& layout);

/// A recorded run is read by load_run(). The unit is the one that the dataset states, else the option's, else
/// that of the model, else V or um with a note on standard error. Throws Error if --from lies after --to,
/// with the name of the file if no row is left, if dataset and option have different units, if the output is
/// not a length like the model's, or if the units of two files differ.
std::vector<identification::Dataset> load_datasets(const std::vector<std::filesystem::path>& files,
                                                   const DatasetInput& input);

}  // namespace hystcan::app
