// Collects the facts about a stage before it moves: from options, records and the DBC. Asks the user for
// missing facts.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/stage/lab_frames.h"
#include "app/stage/model_words.h"
#include "app/stage/questions.h"
#include "app/stage/stage_facts.h"
#include "app/stage/stage_records.h"

namespace hystcan::app {

/// The options of `hystcan init`. A list is empty, or it has one value for all axes, or one value for each
/// axis.
struct InitOptions {
  std::filesystem::path folder{};
  std::string preset{};
  bool yes = false;
  bool carry_on = false;
  bool accept = false;  ///< accept records with data that the stage cannot have caused
  std::vector<std::filesystem::path> records{}, steps{}, unseen{};
  DatasetInput input{};
  ModelWords model{};
  // The following members are facts about the stage that the user states.
  std::vector<std::string> axes{};
  std::optional<std::string> drive_unit{}, card{}, interface {
  }, dbc{};
  StatedRoles roles{};                       ///< signals of the lab's own DBC, by role
  std::vector<std::string> further_roles{};  ///< further roles as text, such as "status.state=MSG.SIG"
  std::vector<double> drive_min{}, drive_max{}, safe_drive{}, stroke_um{}, sensor_at_safe_um{},
      resonance_Hz{}, damping_ratio{}, sensor_delay_us{}, volts_per_drive{}, um_per_V{};
  std::vector<int> nodes{};  ///< node numbers: amplifier and sensor of axis 1, of axis 2, ...
  std::optional<double> rate_Hz{};
};

/// Returns the facts about the stage. `records`: empty, or one element for each axis. If no DBC is stated,
/// uses the shipped DBC for the unit of the drive. Throws Error if an answer is missing, or if a record
/// contradicts an answer.
StageFacts ask_about(const InitOptions& stated, const std::vector<AxisRecords>& records,
                     Questions& questions);

}  // namespace hystcan::app
