// Reads a measured dataset for identification from a CSV file: decides which columns are time, input and
// output, and their units.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "identification/dataset.h"

namespace hystcan::config {

/// The user's options for reading a dataset file.
struct DatasetLayout {
  /// Columns that the user selects, by name or number: "t,V,x" for time, input and output; "t1,V,t2,x" if the
  /// output has a time of its own. Empty: the reader selects the columns by similar names.
  std::string columns{};
  /// Sampling rate that the user gives if the file has no time, or if the time is the sample number.
  std::optional<double> rate_Hz{};
  std::optional<double> output_scale{};    ///< um per base unit of the output: um per V if the file has mV
  std::filesystem::path output_from{};     ///< file with the output; empty: the output is in the same file
  std::optional<double> from_s{}, to_s{};  ///< rows before from_s and after to_s are ignored
  bool has_interval_options = false;       ///< true: the command has the options --from and --to, so that
                                           ///< error messages may suggest them
};

/// Maximum number of rows in a dataset. A dataset needs 24 bytes of memory per row, and memory for the text
/// of the file while it is read.
inline constexpr std::size_t most_dataset_rows = 50'000'000;

struct DatasetFile {
  identification::Dataset dataset;  ///< values converted to base units: ms to s, mV to V, mA to A
  std::string taken;                ///< text about the columns and the rate that the reader selected, such as
                                    ///< "time from t in ms"; may be empty
  std::vector<std::string> notes;   ///< a sentence for each assumption and each ignored part of the file
};

/// Loads a dataset. Selects the columns that `layout` names; else the columns time_s, input and output; else
/// the columns with similar names. The sampling rate is from `layout`, else from the lines above the rows.
/// The rate is used if the file has no time or only the sample number. If the file has times, they must agree
/// with the rate. The lines `# input_unit = ...` and `# output_unit = ...` give the units, if present. Times
/// of day, and times since 1970 in ms, us or ns, are converted to times since the first row. Rows before
/// `from_s` and rows after `to_s` are ignored. Throws Error if the file can't be read or has more than
/// `most_rows` rows, if a row is invalid, if the time does not increase, or if a value exceeds the limit of
/// identification/dataset.h.
DatasetFile load_dataset(const std::filesystem::path& file, const DatasetLayout& layout = {},
                         std::size_t most_rows = most_dataset_rows);

}  // namespace hystcan::config
