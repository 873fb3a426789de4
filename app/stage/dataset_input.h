// Measured datasets as input of the commands that identify: files and recorded runs, an interval of time,
// units.
//
// A recorded run becomes a dataset of the cycles in which one axis is driven.
//
//   time_s   time of SYNC(n), as in the run
//   input    drive of the command that answered SYNC(n-1): in effect from SYNC(n) until SYNC(n+1)
//   output   position at SYNC(n)
//
// This timing equals that of controller/excitation_dataset.h, so a delay means the same for both. The memory
// of the model depends on every drive. The dataset is therefore the longest stretch without an interruption:
// the axis is initialising, ready or tracking, and no cycle is lost. It begins when the drive first moves,
// because the amplifier may be disabled before. Cycles without a sample are left out.
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
  std::string axis;  ///< axis of recorded runs; empty: the only one
  std::string input_unit, output_unit;
  std::string model_output_unit;  ///< unit of length to which outputs are converted; empty: no conversion
  config::DatasetLayout layout;   ///< includes --from and --to
};

/// Throws Error if the unit stated in the file (`# input_unit = "V"`) is not `expected`. An empty `file_unit`
/// means that the file states no unit. `suffix` is appended to the message.
void require_unit(const std::filesystem::path& file, const char* name, const std::string& file_unit,
                  const std::string& expected, const char* suffix = "");

/// Returns the time span from --from to --to. Throws Error if --from is after --to.
runs::TimeSpan span_of(const DatasetInput& input);

/// Adds --columns and --output-scale.
void add_column_options(CLI::App& command, config::DatasetLayout& layout);
/// Adds --rate and the options of add_column_options().
void add_layout_options(CLI::App& command, DatasetInput& input);
/// Adds --from and --to.
void add_interval_options(CLI::App& command, DatasetInput& input);
/// Adds all options above, --input-unit and --output-unit.
void add_dataset_options(CLI::App& command, DatasetInput& input);

/// Throws Error if an axis is named but no file is a recorded run; only runs have axes.
void require_run_for_axis(const std::vector<std::filesystem::path>& files, const DatasetInput& input,
                          const char* otherwise = "");

/// Opens a recorded run. Prints a note on standard error if a crash truncated the run. Throws Error if `run`
/// is not a recorded run.
runs::Run open_run(const std::filesystem::path& run);

/// Loads the longest stretch of a recorded run and prints a note about it on standard error. `axis`: empty:
/// the only one. Throws Error with the name of the run if it is not a run, if it has no such axis, if the
/// axis is not driven in `span`, or if the stretch has more than config::most_dataset_rows rows.
identification::Dataset load_run(const std::filesystem::path& run, const std::string& axis,
                                 const runs::TimeSpan& span);

/// Loads a dataset. Prints a note on standard error if columns were chosen by a similar name, or if the last
/// row was left out.
identification::Dataset load_noting(const std::filesystem::path& file, const config::DatasetLayout& layout);

/// Loads datasets; load_run() loads recorded runs. The unit is that of the dataset, else that of the option,
/// else that of the model, else V or um with a note on standard error. Throws Error if --from is after --to,
/// with the name of the file if no row is left, if dataset and option have different units, if the model's
/// output is a length but the dataset's is not, or if the units of two files differ.
std::vector<identification::Dataset> load_datasets(const std::vector<std::filesystem::path>& files,
                                                   const DatasetInput& input);

}  // namespace hystcan::app
