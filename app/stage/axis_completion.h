// From the records of an axis to its models, its dynamics and its loop, in the folder of a stage.
//
//   loops  -> identify -> NAME.model.toml; NAME.plant.toml, not quite the same; NAME.report/
//   step   -> dynamics -> delays of the controller, mode and amplifier of the twin
//   both   -> tune     -> gains and filters, rehearsed with that twin; NAME.bode.svg
//   unseen -> validate
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/stage/promise.h"
#include "app/stage/stage_records.h"
#include "app/stage/tuning_report.h"
#include "config/schema/config.h"
#include "identification/identify.h"

namespace hystcan::app {

/// The configuration of a stage, which is made complete in memory and is written once.
class Stage {
 public:
  /// Of a configuration with this text, whose paths count from the folder of `file`. Throws Error.
  Stage(std::filesystem::path file, std::string text);

  config::Config config;
  /// Comments that take the place of those behind the keys at these paths.
  std::map<std::string, std::string> comments{};

  /// That of the constructor with the values of `config`.
  std::string text() const;
  const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path file_;
  std::string read_text_;
  config::Config read_;
};

/// Names of the files of an axis beside the configuration.
std::string model_name(const std::string& axis);
std::string plant_name(const std::string& axis);

void print_lines(const std::string& of, const std::vector<std::string>& lines);

/// The model that the loops determine, its thresholds at the ends of the loops. Writes model, plant and
/// report into `folder`. Prints lines for the engineer. Throws Error where the records determine
/// none, RunError at a signal.
identification::Identified identify_axis(const std::filesystem::path& folder, const std::string& axis,
                                         const AxisRecords& records);

/// What the step record of an axis shows; none where there is no such record. Throws Error.
std::optional<IdentifiedPlant> shown_plant(const AxisRecords& records, const controller::Delays& stated);

/// Finds the loop of axis i of the stage. With the plant that a step record shows it is the cautious one,
/// where that tracks. Without one the dynamics are those that were stated, the loop is an integral one that
/// is far from what they allow, and the report is empty.
TuningReport tune_axis(Stage& stage, std::size_t i, const AxisRecords& records,
                       const std::optional<IdentifiedPlant>& plant);

/// The cautious loop of axis i at the rate of the stage, for its plant or for what is stated. Prints nothing.
void set_cautious_loop(Stage& stage, std::size_t i, const std::optional<IdentifiedPlant>& plant);

/// What tracks better than the cautious loop that is set; null where nothing does.
const Candidate* faster_of(const TuningReport& report);

/// What the loop of the report is called that is written first.
std::string loop_name(const TuningReport& report);

/// Rehearses the reference of every axis. `tuned`, `loops`: of each axis. Throws RunError where an axis does
/// not track.
std::vector<Promise> rehearsal_of(const config::Config& config, const std::vector<TuningReport>& tuned,
                                  const std::vector<std::string>& loops);

}  // namespace hystcan::app
