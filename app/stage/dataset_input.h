// Loads measured datasets for the commands that identify: from files or from recorded runs, within a time
// span, with units.
//
// A recorded run becomes a dataset of the cycles in which one axis was driven.
//
//   time_s   time of SYNC(n), as in the run; n is the number of the cycle
//   input    drive of the command that answered SYNC(n-1): in effect from SYNC(n) until SYNC(n+1)
//   output   position at SYNC(n)
//
// A dataset of `hystcan excite` has the same times (controller/excitation_dataset.h), so a delay means the
// same in both datasets. The model's memory depends on every drive, so no record of a cycle may be lost. The
// dataset is therefore the longest stretch without a lost record in which the axis is initialising, ready or
// tracking. The stretch begins when the drive first moves, because the amplifier may be disabled before. If
// only the sample of a cycle is missing, the stretch continues, but this cycle has no row.
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
  std::string axis;  ///< axis to read from recorded runs; empty: the run must have only one axis
  std::string input_unit, output_unit;
  std::string model_output_unit;  ///< length unit to which outputs are converted; empty: no conversion
  config::DatasetLayout layout;   ///< how to read dataset files; includes --from and --to
};

/// Throws Error if the file states a unit (`# input_unit = "V"`) that is not `expected`. `name`: "input_unit"
/// or "output_unit". `file_unit`: unit in the file; empty if the file states none. `suffix` is appended to
/// the message.
void require_unit(const std::filesystem::path& file, const char* name, const std::string& file_unit,
                  const std::string& expected, const char* suffix = "");

/// Returns the time span of the options --from and --to; a missing option is infinite. Throws Error if --from
/// is after --to.
runs::TimeSpan span_of(const DatasetInput& input);

/// Adds the options --columns, --output-from and --output-scale.
void add_column_options(CLI::App& command, config::DatasetLayout& layout);
/// Adds the option --rate and the options of add_column_options().
void add_layout_options(CLI::App& command, DatasetInput& input);
/// Adds the options --from and --to.
void add_interval_options(CLI::App& command, DatasetInput& input);
/// Adds the options of add_layout_options() and add_interval_options(), and the options --input-unit and
/// --output-unit.
void add_dataset_options(CLI::App& command, DatasetInput& input);

/// Throws Error if the user names an axis but no file is a recorded run, because only runs have axes.
/// `otherwise` is appended to the expected input in the message.
void require_run_for_axis(const std::vector<std::filesystem::path>& files, const DatasetInput& input,
                          const char* otherwise = "");

/// Opens a recorded run. If a crash truncated it, prints a note on standard error. Throws Error if `run` is
/// not a recorded run.
runs::Run open_run(const std::filesystem::path& run);

/// Loads the longest driven stretch of an axis from a recorded run, and prints a note about it on standard
/// error. If `axis` is empty, the run must have only one axis. Throws Error if the path is not a run, if it
/// has no such axis, if the axis is not driven in `span`, or if the stretch has more than
/// config::most_dataset_rows rows.
identification::Dataset load_run(const std::filesystem::path& run, const std::string& axis,
                                 const runs::TimeSpan& span);

/// Loads a dataset file. Prints a note on standard error if columns were detected by a similar name, or if
/// the incomplete last row was left out.
identification::Dataset load_noting(const std::filesystem::path& file, const config::DatasetLayout& layout);

/// Loads dataset files and recorded runs. The unit of a dataset is taken from its file, or else from the
/// option, or else (for the output) from the model; if none states a unit, V or um is assumed with a note on
/// standard error. Throws Error if --from is after --to, if a file has no rows in this span, if file and
/// option state different units, if the model's output is a length but the dataset's is not, or if two files
/// have different units.
std::vector<identification::Dataset> load_datasets(const std::vector<std::filesystem::path>& files,
                                                   const DatasetInput& input);

}  // namespace hystcan::app
