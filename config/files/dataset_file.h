// Reads a measured dataset for identification from a CSV file: which columns are time, input and output, in
// what units.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "identification/dataset.h"

namespace hystcan::config {

/// What the user says about the file.
struct DatasetLayout {
  /// "t,V,x": names or numbers of time, input and output; empty: by likeness. "t1,V,t2,x": two times.
  std::string columns{};
  std::optional<double> rate_Hz{};         ///< there is no time, or it is the number of the sample
  std::optional<double> output_scale{};    ///< um of one unit of the output: of 1 V, where it is in mV
  std::filesystem::path output_from{};     ///< file of the output; empty: that of the input
  std::optional<double> from_s{}, to_s{};  ///< the rows before and after are not judged
  bool has_interval_options = false;       ///< a message may advise --from and --to
};

/// A dataset is in memory as a whole, with 24 bytes for each row, and its text while it is read.
inline constexpr std::size_t most_dataset_rows = 50'000'000;

struct DatasetFile {
  identification::Dataset dataset;  ///< in s, V or A where the file has multiples of them
  std::string taken;  ///< which columns were taken by likeness: "time from t [ms], ..."; empty: none
  std::vector<std::string> notes;  ///< what was assumed or left out
};

/// The columns are time_s, input and output, or what `layout` and the header say (lab_csv.h). The sampling
/// rate is that of `layout`, else the one stated above the rows, where the file has no time or the number
/// of the sample; beside a time it must agree. The lines `# input_unit = ...` and `# output_unit = ...` state
/// the units, if they exist. Times of day and milliseconds since 1970 count from the first row. Reading
/// begins at the first row from `from_s` on and ends at the first one that reaches `to_s`. Throws Error if
/// the file cannot be read, with the place where a row is none; if time does not increase; if a value is
/// beyond the limits of identification/dataset.h; or if there are more than `most_rows`.
DatasetFile load_dataset(const std::filesystem::path& file, const DatasetLayout& layout = {},
                         std::size_t most_rows = most_dataset_rows);

}  // namespace hystcan::config
