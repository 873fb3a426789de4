// Loads the measured records of an axis, from which a stage is set up.
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

/// The records of an axis: their files and, after load(), their datasets with positions in um. A dataset
/// exists only if its file is given.
struct AxisRecords {
  std::vector<std::filesystem::path> loop_files;  ///< slow loops, for the hysteresis
  /// `step_file`: small fast steps, for the dynamics. `unseen_file`: for the validation of the model.
  std::optional<std::filesystem::path> step_file{}, unseen_file{};
  std::vector<identification::Dataset> loops{};
  std::optional<identification::Dataset> step{}, unseen{};
  identification::IdentifyOptions model{};  ///< options for the identification of the model

  model::Interval drive() const;           ///< range of the drive in all records of loops
  model::Interval travel_um() const;       ///< range of the position in all records of loops
  std::vector<std::string> names() const;  ///< names of the loop files, without their folders
};

/// Loads the datasets of all files in `records`. Throws Error with the name of the file if the output is not
/// a length, or if two files have the same rows. Also throws if a record contains data that the stage cannot
/// have caused (record_warnings.h). With `accept`, prints a warning on standard error instead and leaves out
/// drop-outs and glitches; the rows of a saturated sensor are used.
void load(AxisRecords& records, const DatasetInput& input, bool accept);

/// Throws Error if a record contradicts the known facts: its drive has another unit or exceeds the range
/// `drive`, or its travel does not agree with `stroke_um`.
void refuse_contradictions(const AxisRecords& records, const std::string& drive_unit,
                           const model::Interval& drive, std::optional<double> stroke_um);

}  // namespace hystcan::app
