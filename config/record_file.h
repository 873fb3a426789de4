// A measured record from a CSV file, whole: what is identified from.
#pragma once

#include <filesystem>

#include "identification/record.h"

namespace hystcan::config {

struct RecordFile {
  identification::Record record;
  bool last_row_left_out = false;  ///< no line end after it: it may have been cut in the middle of a number
};

/// Columns time_s, input, output; units where lines `# input_unit = ...`, `# output_unit = ...` tell them.
/// Throws Error at what CsvReader refuses, and where time does not increase.
RecordFile load_record(const std::filesystem::path& file);

}  // namespace hystcan::config
