// Reads a measured dataset for identification from a CSV file: which columns are time, input and output, in
// what units.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "base/error.h"
#include "identification/dataset.h"

namespace hystcan::config {

/// What the user says about the file.
struct DatasetLayout {
  std::string columns{};  ///< "t,V,x": names or numbers of time, input and output; empty: by likeness
  std::optional<double> rate_Hz{};       ///< there is no time, or it is the number of the sample
  std::optional<double> output_scale{};  ///< um of one unit of the output column
};

/// A dataset is in memory as a whole, with 24 bytes for each row.
inline constexpr std::size_t most_dataset_rows = 50'000'000;

struct DatasetFile {
  identification::Dataset dataset;  ///< in s, V or A where the file has multiples of them
  bool last_row_left_out = false;   ///< it has no line end, so its last number may be incomplete
  std::string taken;  ///< which columns were taken by likeness: "time from t [ms], ..."; empty: none
};

/// The columns are time_s, input and output, or what `layout` and the header say (lab_csv.h). The sampling
/// rate is that of `layout`, else the one stated above the header, where the file has no time or the number
/// of the sample; beside a time it must agree. The lines `# input_unit = ...` and `# output_unit = ...` state
/// the units, if they exist. Throws Error if the file cannot be read, with the place where a row is none; if
/// time does not increase; if a value is beyond the limits of identification/dataset.h; or if there are more
/// than `most_rows`.
DatasetFile load_dataset(const std::filesystem::path& file, const DatasetLayout& layout = {},
                         std::size_t most_rows = most_dataset_rows);

}  // namespace hystcan::config
