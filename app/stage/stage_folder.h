// Creates the folder of a stage with configuration, models, DBC and reports.
//
//   make_stage       with records: the complete stage.toml. Without: first.toml, for the first excitation
//   continue_stage   stage.toml from first.toml and the records in the same folder
//   copy_preset      a copy of a shipped configuration
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/stage/stage_questions.h"

namespace hystcan::app {

/// Creates the folder. Prints the warnings of `hystcan check` if there are records, and the next commands.
/// Throws Error if the facts or the records are insufficient. Throws RunError at a signal, or if a rehearsal
/// ends with a fault. No folder remains after an error, with one exception: after a fault in a rehearsal, the
/// models and reports are kept for `hystcan demo`.
void make_stage(const std::filesystem::path& folder, StageFacts facts,
                const std::vector<AxisRecords>& records);

/// Completes a stage from the records in its folder: AXIS.loops.csv and, if they exist, AXIS.slow.csv,
/// AXIS.unseen.csv and AXIS.step.csv. Replaces no file. If it fails, no new file remains, except after a
/// fault in the rehearsal. Throws under the same conditions as make_stage() and load() (stage_records.h).
void continue_stage(const std::filesystem::path& folder, const ModelWords& model, bool accept);

/// Copies a shipped configuration to `folder`. `preset`: its name without .toml. Throws Error if there is no
/// such configuration.
void copy_preset(const std::string& preset, const std::filesystem::path& folder);

}  // namespace hystcan::app
