// Identifies and tunes one axis of a stage from its records, and writes the results into the stage's folder.
//
//   record   step       result
//   loops    identify   NAME.model.toml; NAME.plant.toml, deliberately inexact; NAME.report/
//   step     dynamics   delays of the controller, mode and amplifier of the twin
//   both     tune       gains and filters, rehearsed with that twin; NAME.bode.svg
//   unseen   validate   a line with the prediction error
//
// The records are those of AxisRecords: "both" means loops and step, and "unseen" is a record that identify
// does not use. NAME.plant.toml is the twin's actuator. It is deliberately inexact, so that a rehearsal shows
// the effect of model errors.
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

/// The configuration of a stage. It is completed in memory and then written once.
class Stage {
 public:
  /// Parses `text` as a configuration. Relative paths in it refer to the folder of `file`. Throws Error if
  /// the text is invalid.
  Stage(std::filesystem::path file, std::string text);

  config::Config config;
  /// New comments, by the path of a key. Each one replaces the comment after its key.
  std::map<std::string, std::string> comments{};

  /// Returns the original text with the current values of `config` and with the new comments.
  std::string text() const;
  const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path file_;
  std::string read_text_;
  config::Config read_;
};

/// Return the names of the model files of an axis: the controller's model and the twin's actuator. The files
/// are in the folder of the configuration.
std::string model_name(const std::string& axis);
std::string plant_name(const std::string& axis);

void print_lines(const std::string& of, const std::vector<std::string>& lines);

/// Identifies the hysteresis model of an axis from its loops. The ends of the loops become the thresholds of
/// the model. Writes model, twin's actuator and report into `folder`, and prints the results. A measured
/// drive may exceed `range` because of noise; such drives are set to the ends of `range`. Throws Error if the
/// records do not determine a model, and RunError at a signal.
identification::Identified identify_axis(const std::filesystem::path& folder, const std::string& axis,
                                         AxisRecords records, const model::Interval& range);

/// Identifies the dynamics of an axis from its step record; returns `nullopt` if there is no such record.
/// `stated`: dynamics as stated by the user. Throws Error if the record does not determine the dynamics.
std::optional<IdentifiedPlant> shown_plant(const AxisRecords& records, const controller::Delays& stated);

/// Tunes the loop of axis i of the stage. With `plant`, sets the cautious loop, or the proposed loop if the
/// cautious loop does not track in a rehearsal. Without `plant`, sets an integral loop with a low gain for
/// the stated dynamics, and returns an empty report.
TuningReport tune_axis(Stage& stage, std::size_t i, const AxisRecords& records,
                       const std::optional<IdentifiedPlant>& plant);

/// Sets the loop of axis i for the cycle rate of the stage. With `plant` (identified dynamics), sets the
/// cautious loop. Without `plant`, sets an integral loop with a low gain for the dynamics in the
/// configuration, which the user stated or which are defaults. In contrast to tune_axis(), does not test the
/// loop on the twin and prints nothing.
void set_cautious_loop(Stage& stage, std::size_t i, const std::optional<IdentifiedPlant>& plant);

/// Returns the proposed candidate if its predicted error is at least 2 % smaller than the predicted error of
/// the loop in stage.toml; otherwise null.
const Candidate* faster_of(const TuningReport& report);

/// Returns the name of the loop in stage.toml, for example "cautious".
std::string loop_name(const TuningReport& report);

/// Rehearses the references of all axes together and returns a promise for each axis. `tuned`, `loops`:
/// report and name of the loop for each axis. Throws RunError if an axis does not track.
std::vector<Promise> rehearsal_of(const config::Config& config, const std::vector<TuningReport>& tuned,
                                  const std::vector<std::string>& loops);

}  // namespace hystcan::app
