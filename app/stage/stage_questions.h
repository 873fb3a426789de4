// Collects the facts about a stage before it moves: from options, records and the DBC, and the rest by
// questions.
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

/// The options of `hystcan init`. Lists have one value for all axes, one for each, or none.
struct InitOptions {
  std::filesystem::path folder{};
  std::string preset{};
  bool yes = false;
  bool carry_on = false;
  bool accept = false;  ///< accept records that the stage cannot have caused
  std::vector<std::filesystem::path> records{}, steps{}, unseen{};
  DatasetInput input{};
  ModelWords model{};
  // Known facts about the stage:
  std::vector<std::string> axes{};
  std::optional<std::string> drive_unit{}, card{}, interface {
  }, dbc{};
  StatedRoles roles{};                       ///< roles of the lab's own signals
  std::vector<std::string> further_roles{};  ///< "status.state=MSG.SIG", to be added to `roles`
  std::vector<double> drive_min{}, drive_max{}, safe_drive{}, stroke_um{}, sensor_at_safe_um{},
      resonance_Hz{}, damping_ratio{}, sensor_delay_us{}, volts_per_drive{}, um_per_V{};
  std::vector<int> nodes{};  ///< amplifier and sensor of the first axis, of the second one ...
  std::optional<double> rate_Hz{};
};

/// Returns the facts. `records`: one element for each axis, or none. Without a stated DBC, the shipped DBC
/// for the drive's unit is used. Throws Error if an answer is missing or if a record contradicts an answer.
StageFacts ask_about(const InitOptions& stated, const std::vector<AxisRecords>& records,
                     Questions& questions);

}  // namespace hystcan::app
