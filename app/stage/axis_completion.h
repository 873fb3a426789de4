// Turns the records of an axis into its models, its dynamics and its loop, in the folder of a stage.
//
//   loops  -> identify -> NAME.model.toml; NAME.plant.toml, deliberately inexact; NAME.report/
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

/// The configuration of a stage, which is completed in memory and then written once.
class Stage {
 public:
  /// Parses `text`. Paths in it are relative to the folder of `file`. Throws Error.
  Stage(std::filesystem::path file, std::string text);

  config::Config config;
  /// New comments for keys, by the paths of the keys; each replaces the present comment after its key.
  std::map<std::string, std::string> comments{};

  /// Returns the text that was passed to the constructor, with the present values of `config`.
  std::string text() const;
  const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path file_;
  std::string read_text_;
  config::Config read_;
};

/// Return the names of an axis's files, which are in the folder of the configuration.
std::string model_name(const std::string& axis);
std::string plant_name(const std::string& axis);

void print_lines(const std::string& of, const std::vector<std::string>& lines);

/// Identifies the model of an axis from its loops; the ends of the loops set its thresholds. Drives beyond
/// `range`, the noise of a measured drive, are moved to its ends. Writes model, plant and report into
/// `folder`. Prints lines for the engineer. Throws Error if the records do not determine a model, RunError at
/// a signal.
identification::Identified identify_axis(const std::filesystem::path& folder, const std::string& axis,
                                         AxisRecords records, const model::Interval& range);

/// Identifies the plant from the step record of an axis; `nullopt` without a step record. Throws Error.
std::optional<IdentifiedPlant> shown_plant(const AxisRecords& records, const controller::Delays& stated);

/// Tunes the loop of axis i of the stage. With `plant`, the cautious loop is set if it tracks. Without
/// `plant`, the stated dynamics are used, the loop is an integral one with low gain, and the report is empty.
TuningReport tune_axis(Stage& stage, std::size_t i, const AxisRecords& records,
                       const std::optional<IdentifiedPlant>& plant);

/// Sets the cautious loop of axis i at the rate of the stage, for `plant` or else for the stated dynamics.
/// Prints nothing.
void set_cautious_loop(Stage& stage, std::size_t i, const std::optional<IdentifiedPlant>& plant);

/// Returns the best candidate that tracks better than the present cautious loop; null if there is none.
const Candidate* faster_of(const TuningReport& report);

/// Returns the name of the loop that is written first.
std::string loop_name(const TuningReport& report);

/// Rehearses the references of all axes. `tuned`, `loops`: one element for each axis. Throws RunError if an
/// axis does not track.
std::vector<Promise> rehearsal_of(const config::Config& config, const std::vector<TuningReport>& tuned,
                                  const std::vector<std::string>& loops);

}  // namespace hystcan::app
