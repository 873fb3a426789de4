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

/// The user's options for the file.
struct DatasetLayout {
  /// "t,V,x": names or numbers of time, input and output; "t1,V,t2,x": two times. Empty: by similar names.
  std::string columns{};
  /// Sampling rate. Set if the file has no time, or if its time is the sample number.
  std::optional<double> rate_Hz{};
  std::optional<double> output_scale{};    ///< um per unit of the output: per 1 V, even if the file is in mV
  std::filesystem::path output_from{};     ///< file of the output; empty: same file as the input
  std::optional<double> from_s{}, to_s{};  ///< rows before and after are ignored
  bool has_interval_options = false;       ///< the command has --from and --to: a message may suggest them
};

/// Maximum rows of a dataset. It is stored in memory with 24 bytes per row, plus its text while it is read.
inline constexpr std::size_t most_dataset_rows = 50'000'000;

struct DatasetFile {
  identification::Dataset dataset;  ///< in s, V or A, converted from their multiples
  std::string taken;                ///< columns selected by similarity: "time from t [ms], ..."; empty: none
  std::vector<std::string> notes;   ///< assumptions and omissions
};

/// Selects the columns time_s, input and output, or the columns given by `layout` or the header (lab_csv.h).
/// The sampling rate is from `layout`, else from the lines above the rows, and applies if the file has no
/// time or only the sample number; if the file has times, the rate must agree with them. The lines
/// `# input_unit = ...` and `# output_unit = ...` give the units, if present. Times of day and milliseconds
/// since 1970 count from the first row. Reading begins at the first row at or after `from_s` and ends at the
/// first row beyond `to_s`.
/// Throws Error if the file can't be read or has more than `most_rows` rows, if a row is invalid (with its
/// place), if time does not increase, or if a value exceeds the limits of identification/dataset.h.
DatasetFile load_dataset(const std::filesystem::path& file, const DatasetLayout& layout = {},
                         std::size_t most_rows = most_dataset_rows);

}  // namespace hystcan::config
