// Reads a measured dataset for identification from a CSV file.
#pragma once

#include <cstddef>
#include <filesystem>

#include "identification/dataset.h"

namespace hystcan::config {

/// A dataset is in memory as a whole, with 24 bytes for each row.
inline constexpr std::size_t most_dataset_rows = 50'000'000;

struct DatasetFile {
  identification::Dataset dataset;
  bool last_row_left_out = false;  ///< it has no line end, so its last number may be incomplete
};

/// The columns are time_s, input and output. The lines `# input_unit = ...` and `# output_unit = ...` state
/// the units, if they exist. Throws the errors of CsvReader, and an Error if time does not increase, or if there
/// are more than `most_rows`.
DatasetFile load_dataset(const std::filesystem::path& file, std::size_t most_rows = most_dataset_rows);

}  // namespace hystcan::config
