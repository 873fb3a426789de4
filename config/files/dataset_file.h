// Reads a measured dataset for identification from a CSV file.
#pragma once

#include <filesystem>

#include "identification/dataset.h"

namespace hystcan::config {

struct DatasetFile {
  identification::Dataset dataset;
  bool last_row_left_out = false;  ///< it has no line end, so its last number may be incomplete
};

/// The columns are time_s, input and output. The lines `# input_unit = ...` and `# output_unit = ...` state
/// the units, if they exist. Throws the errors of CsvReader, and an Error if time does not increase.
DatasetFile load_dataset(const std::filesystem::path& file);

}  // namespace hystcan::config
