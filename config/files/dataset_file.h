// A measured dataset from a CSV file, whole: what is identified from.
#pragma once

#include <filesystem>

#include "identification/dataset.h"

namespace hystcan::config {

struct DatasetFile {
  identification::Dataset dataset;
  bool last_row_left_out = false;  ///< no line end after it: it may have been cut in the middle of a number
};

/// Columns time_s, input, output; units where lines `# input_unit = ...`, `# output_unit = ...` tell them.
/// Throws Error at what CsvReader refuses, and where time does not increase.
DatasetFile load_dataset(const std::filesystem::path& file);

}  // namespace hystcan::config
