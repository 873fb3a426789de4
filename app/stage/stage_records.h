// The measured records of an axis, as the set-up of a stage takes them.
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

/// Positions are in um. Without a file there is no dataset.
struct AxisRecords {
  std::vector<std::filesystem::path> loop_files;                    ///< slow ones, for the hysteresis
  std::optional<std::filesystem::path> step_file{}, unseen_file{};  ///< small and fast; for the validation
  std::vector<identification::Dataset> loops{};
  std::optional<identification::Dataset> step{}, unseen{};
  identification::IdentifyOptions model{};  ///< how the model of the loops is identified

  model::Interval drive() const;           ///< of the loops
  model::Interval travel_um() const;       ///< likewise
  std::vector<std::string> names() const;  ///< of the files of the loops, without folders
};

/// Reads the files. Throws Error with the name of the file: where the output is no length, if two files have
/// the same rows, and if a record shows what is not of the stage (record_doubts.h). `accept`: doubts are
/// noted on standard error instead, and rows that no stage makes are left out.
void load(AxisRecords& records, const DatasetInput& input, bool accept);

/// Throws Error where a record contradicts what is known: another unit, a drive beyond its range, a
/// stroke that is not `stroke_um`.
void refuse_contradictions(const AxisRecords& records, const std::string& drive_unit,
                           const model::Interval& drive, std::optional<double> stroke_um);

}  // namespace hystcan::app
