// The measured records of an axis, as the set-up of a stage takes them.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "app/stage/dataset_input.h"
#include "app/stage/stage_facts.h"
#include "identification/dataset.h"
#include "model/reference_curve.h"

namespace hystcan::app {

struct RecordFiles {
  std::vector<std::filesystem::path> loops;     ///< slow ones, for the hysteresis
  std::optional<std::filesystem::path> step;    ///< small and fast, for the dynamics
  std::optional<std::filesystem::path> unseen;  ///< for the validation
};

/// Positions are in um.
struct AxisRecords {
  RecordFiles files;
  std::vector<identification::Dataset> loops;
  std::optional<identification::Dataset> step, unseen;

  model::Interval drive() const;           ///< of the loops
  model::Interval travel_um() const;       ///< likewise
  std::vector<std::string> names() const;  ///< of the files of the loops, without folders
};

/// Throws Error with the name of the file, also where the output is no length.
AxisRecords load_records(const RecordFiles& files, const DatasetInput& input);

/// Throws Error where a record contradicts what is known: another unit, a drive beyond its range, a stroke that is
/// not `stroke_um`.
void refuse_contradictions(const AxisRecords& records, const AxisFacts& axis,
                           std::optional<double> stroke_um);

}  // namespace hystcan::app
