// Finds data in a measured record that the stage cannot have caused, and describes them in sentences:
// drop-outs, glitches, a saturated sensor, and a record that is given twice (identification/suspect_rows.h).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::app {

struct RecordWarning {
  std::string fact;  ///< what was found: file, value, row and time, or the number of rows
  std::string consequence;

  std::string text() const { return fact + "; " + consequence; }
};

/// Removes drop-outs and glitches from the dataset. Returns a warning about them, and one warning for each
/// end of the range at which the sensor was saturated. A warning contains row numbers: row 1 is the first row
/// of `dataset`, from which the rows before --from were already removed.
std::vector<RecordWarning> leave_out_suspects(const std::filesystem::path& file,
                                              identification::Dataset& dataset);

/// Throws Error if one of the two datasets has the same rows as the other dataset, or as a part of the other
/// dataset.
void refuse_same_rows(const std::filesystem::path& file, const identification::Dataset& dataset,
                      const std::filesystem::path& other_file, const identification::Dataset& other);
/// Throws Error if two of the datasets have the same rows.
void refuse_same_rows(const std::vector<std::filesystem::path>& files,
                      const std::vector<identification::Dataset>& datasets);

}  // namespace hystcan::app
