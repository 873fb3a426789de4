// Describes in sentences the parts of a measured record that the stage cannot have caused: drop-outs and
// glitches, a saturated sensor, and a record that is given twice (identification/suspect_rows.h).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::app {

struct RecordWarning {
  std::string fact;  ///< includes the file, value, row and time, or the number of rows
  std::string consequence;

  std::string text() const { return fact + "; " + consequence; }
};

/// Removes drop-outs and glitches from the dataset. Returns a warning about them, and one for each end of the
/// sensor's range. Row numbers count from the first row between --from and --to.
std::vector<RecordWarning> leave_out_suspects(const std::filesystem::path& file,
                                              identification::Dataset& dataset);

/// Throws Error if the rows of a dataset equal those of another one, or a part of them.
void refuse_same_rows(const std::filesystem::path& file, const identification::Dataset& dataset,
                      const std::filesystem::path& other_file, const identification::Dataset& other);
/// Throws Error if any two datasets have the same rows.
void refuse_same_rows(const std::vector<std::filesystem::path>& files,
                      const std::vector<identification::Dataset>& datasets);

}  // namespace hystcan::app
