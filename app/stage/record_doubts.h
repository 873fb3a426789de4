// What a measured record shows that is not of the stage: drop-outs and glitches, a sensor at its end, and a
// record that is given twice (identification/suspect_rows.h), in sentences.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::app {

struct RecordDoubt {
  std::string fact;  ///< with the file, value, row and time, or number of rows
  std::string consequence;

  std::string text() const { return fact + "; " + consequence; }
};

/// Takes drop-outs and glitches out of the dataset. Returns a doubt about them, and one for each end of the
/// sensor. Numbers of rows count from the first row between --from and --to.
std::vector<RecordDoubt> leave_out_suspects(const std::filesystem::path& file,
                                            identification::Dataset& dataset);

/// Throws Error if the rows of a dataset are those of another one, or a part of them.
void refuse_same_rows(const std::filesystem::path& file, const identification::Dataset& dataset,
                      const std::filesystem::path& other_file, const identification::Dataset& other);
/// Likewise of any two datasets.
void refuse_same_rows(const std::vector<std::filesystem::path>& files,
                      const std::vector<identification::Dataset>& datasets);

}  // namespace hystcan::app
