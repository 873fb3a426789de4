// The folder of a stage: configuration, models, DBC, reports.
//
//   make_stage       with records: stage.toml, complete. Without: first.toml, to excite the stage with
//   continue_stage   stage.toml from first.toml and the records in the same folder
//   copy_preset      a shipped configuration
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/stage/stage_questions.h"

namespace hystcan::app {

/// Creates the folder, and prints the findings and the next commands. The folder is complete or absent
/// afterwards. Throws Error if facts or records are insufficient, RunError at a signal or if the rehearsal
/// ends with a fault.
void make_stage(const std::filesystem::path& folder, StageFacts facts,
                const std::vector<AxisRecords>& records);

/// Reads AXIS.loops.csv and, if they exist, AXIS.slow.csv, AXIS.unseen.csv and AXIS.step.csv. Overwrites no
/// file, and leaves no new file if it fails. Throws like make_stage() and load() (stage_records.h).
void continue_stage(const std::filesystem::path& folder, const ModelWords& model, bool accept);

/// `preset`: the name of a shipped configuration, without .toml. Throws Error if there is none.
void copy_preset(const std::string& preset, const std::filesystem::path& folder);

}  // namespace hystcan::app
