// From the records of an axis to its models, its dynamics and its loop, in the folder of a stage.
//
//   loops  -> identify -> NAME.model.toml; NAME.plant.toml, not quite the same; NAME.report/
//   step   -> dynamics -> delays of the controller, mode and amplifier of the twin
//   both   -> tune     -> gains and filters, rehearsed with that twin; NAME.bode.svg
//   unseen -> validate
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/stage/config_edit.h"
#include "app/stage/stage_records.h"
#include "config/schema/config.h"
#include "model/hysteresis_parameters.h"

namespace hystcan::app {

/// Names of the files of an axis beside the configuration.
std::string model_name(const std::string& axis);
std::string plant_name(const std::string& axis);

/// The model that the loops determine, its thresholds at the ends of the loops. Writes model, plant and report into
/// `folder`. Returns lines for the engineer. Throws Error where the records determine none, RunError at a signal.
struct IdentifiedAxis {
  model::HysteresisParameters parameters;
  double noise_um = 0.0;  ///< of one sample
  std::vector<std::string> lines;
};
IdentifiedAxis identify_axis(const std::filesystem::path& folder, const std::string& axis,
                             const AxisRecords& records);

/// Finds dynamics and loop of axis i and writes them into the text of the configuration. Without a step record the dynamics
/// are those that were stated, and the loop is an integral one that is far from what they allow. With one it is the cautious
/// one, where that tracks.
struct TunedAxis {
  std::optional<LoopKeys> fast{};  ///< what tracks better than the cautious loop that is written
  double unshared_s = 0.0;         ///< measured delay, of which nobody has stated how much is the sensor's
  bool mode_is_shown = false;      ///< by a record; else it is the stated one
  std::vector<std::string> lines{};
};
TunedAxis tune_axis(const std::filesystem::path& config_file, std::size_t i, const AxisRecords& records);

/// Runs the reference of every axis once with the twin, and again where the delay is the sensor's or is not, and where a
/// mode that no record shows is another one. Returns lines; throws RunError where an axis does not track.
std::vector<std::string> rehearsal_of(const config::Config& config, const std::vector<TunedAxis>& tuned);

}  // namespace hystcan::app
