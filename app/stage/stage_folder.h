// The folder of a stage: configuration, models, DBC, reports.
//
//   make_stage       with records: stage.toml, complete. Without: first.toml, to excite the stage with
//   continue_stage   stage.toml from first.toml and the records that lie beside it
//   copy_preset      a shipped configuration
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/stage/stage_questions.h"

namespace hystcan::app {

/// Prints what it found and the next commands. The folder is complete or absent. Throws Error where
/// what is known or recorded does not do, RunError at a signal or where the rehearsal ends with a fault.
void make_stage(const std::filesystem::path& folder, StageFacts facts,
                const std::vector<AxisRecords>& records);

/// The records are AXIS.loops.csv and, if they are there, AXIS.slow.csv, AXIS.unseen.csv and AXIS.step.csv.
/// Overwrites nothing, and leaves nothing if it fails. Throws like make_stage() and load() (stage_records.h).
void continue_stage(const std::filesystem::path& folder, const ModelWords& model, bool accept);

/// `preset`: the name of a shipped configuration, without .toml. Throws Error if there is none.
void copy_preset(const std::string& preset, const std::filesystem::path& folder);

}  // namespace hystcan::app
