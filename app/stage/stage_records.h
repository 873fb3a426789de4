// The measured records of an axis, used to set up a stage.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/stage/dataset_input.h"
#include "identification/dataset.h"
#include "identification/search.h"
#include "model/reference_curve.h"

namespace hystcan::app {

/// Positions are in um. A dataset exists only if its file is given.
struct AxisRecords {
  std::vector<std::filesystem::path> loop_files;                    ///< slow loops, for the hysteresis
  std::optional<std::filesystem::path> step_file{}, unseen_file{};  ///< step_file: small fast steps;
                                                                    ///< unseen_file: for the validation
  std::vector<identification::Dataset> loops{};
  std::optional<identification::Dataset> step{}, unseen{};
  identification::IdentifyOptions model{};  ///< options for identifying the model of the loops

  model::Interval drive() const;           ///< range of the drives in the loops
  model::Interval travel_um() const;       ///< range of the positions in the loops
  std::vector<std::string> names() const;  ///< names of the loop files, without folders
};

/// Reads the files. Throws Error with the name of the file if the output is not a length, if two files have
/// the same rows, or if a record contains data that the stage cannot have caused (record_warnings.h). `accept`:
/// prints such warnings on standard error instead, and leaves those rows out.
void load(AxisRecords& records, const DatasetInput& input, bool accept);

/// Throws Error if a record contradicts known facts: another unit, a drive beyond its range, or a stroke that
/// is not `stroke_um`.
void refuse_contradictions(const AxisRecords& records, const std::string& drive_unit,
                           const model::Interval& drive, std::optional<double> stroke_um);

}  // namespace hystcan::app
