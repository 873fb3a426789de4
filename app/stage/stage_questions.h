// What has to be known of a stage before it moves: from options, from records, from the DBC, and the rest by
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

/// What the options of `hystcan init` say. Lists have one value for all axes, one for each, or none.
struct InitOptions {
  std::filesystem::path folder{};
  std::string preset{};
  bool yes = false;
  bool carry_on = false;
  bool accept = false;  ///< records that show what is not of the stage
  std::vector<std::filesystem::path> records{}, steps{}, unseen{};
  DatasetInput input{};
  ModelWords model{};
  // What is known of the stage:
  std::vector<std::string> axes{};
  std::optional<std::string> drive_unit{}, card{}, interface {
  }, dbc{};
  StatedRoles roles{};                       ///< of the lab's own signals
  std::vector<std::string> further_roles{};  ///< "status.state=MSG.SIG", to be added to `roles`
  std::vector<double> drive_min{}, drive_max{}, safe_drive{}, stroke_um{}, sensor_at_safe_um{},
      resonance_Hz{}, damping_ratio{}, sensor_delay_us{}, volts_per_drive{}, um_per_V{};
  std::vector<int> nodes{};  ///< amplifier and sensor of the first axis, of the second one ...
  std::optional<double> rate_Hz{};
};

/// `records`: one for each axis, or none. Where no DBC is named it is the shipped one for the drive's unit.
/// Throws Error where an answer is missing, or where a record contradicts one.
StageFacts ask_about(const InitOptions& stated, const std::vector<AxisRecords>& records,
                     Questions& questions);

}  // namespace hystcan::app
