// The result of `hystcan tune` as text, as a fragment of a configuration and as JSON; the frequency response
// of its experiment, of the identified mode and of two loops, as a table and as a picture.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/stage/identified_plant.h"
#include "app/stage/promise.h"
#include "app/stage/rate_choice.h"
#include "controller/analysis/loop_design.h"
#include "controller/control/law.h"
#include "controller/control/statistics.h"
#include "controller/reference/excitation.h"
#include "identification/dataset.h"

namespace hystcan::app {

/// One way to set the loop of an axis, and its predicted effect.
struct Candidate {
  std::string name;                                ///< "present", "plain", "low pass", "notch", "cautious"
  controller::LoopConfig loop;                     ///< its delays are those of the feed-forward
  std::optional<controller::JudgedLoop> judged{};  ///< empty if ki is zero: there is no loop to judge
  /// Of the configured reference, with the configured structure and limits, without learning; empty: not
  /// rehearsed, as it is not stable.
  std::optional<controller::AxisOutcome> predicted{};
  std::optional<double> true_rms_um{};  ///< of the same run, between the samples too; empty: not known
  /// The same without following-error limit, by all_structures; of the present and the proposed ones only.
  std::vector<controller::AxisOutcome> by_structure{};

  bool has_run() const;
  double rms_percent() const;  ///< of the stroke
};

/// Index of the one with the smallest predicted error at the samples, of those that are at most this
/// sensitive at all corners. The first one, the present one, is chosen unless another one is better there by
/// 2 % and, where that is known, not worse between the samples.
std::size_t best_of(const std::vector<Candidate>& candidates, double peak_sensitivity);

struct TuningReport {
  std::string config;  ///< the file's name, without its folder
  std::string axis;
  std::string drive_unit;
  std::string actuator;  ///< the model file of the twin
  std::string record;    ///< the file's name, without its folder; empty: an experiment with these steps
  bool rehearsed = false;
  controller::Excitation::Steps steps;
  double rate_Hz = 0.0;
  IdentifiedPlant plant;
  controller::SensitivityRule rule{};
  controller::CautiousRule cautious_rule{};
  bool only_cautious = false;
  std::vector<Candidate> candidates;  ///< the present one is the first
  std::size_t best = 0;
  double unshared_s = 0.0;           ///< of the measured delay; 0 where the configuration states the sensor's
  std::optional<Promise> promise{};  ///< of the proposed loop; none: it was not asked for
  std::optional<RateOffer> offer{};  ///< another rate that would be better, with a cautious loop

  const Candidate& present() const { return candidates.front(); }
  const Candidate& proposed() const { return candidates[best]; }
};

/// What its experiment leaves open. A report without an experiment knows the mode as it is stated.
Doubt doubt_of(const TuningReport& report);

std::string describe(const TuningReport& report);
/// The keys of [axis.control] to replace, each with its present value in a comment.
std::string fragment(const TuningReport& report);
nlohmann::json to_json(const TuningReport& report);

/// CSV, a row for each measured frequency. Gains of plant and model are 1 at rest; phases are in degrees,
/// those of the loops from -90 on without a leap.
std::string response_table(const TuningReport& report, const identification::Dataset& record);

/// Draws `picture` (.svg or .png). Its data remain beside it: the response_table() with rows of the curves
/// after it (.data.csv), and the list (.json, pictures.h). Returns why there is no picture, if there is none.
std::optional<std::string> draw_response(const TuningReport& report, const identification::Dataset& record,
                                         const std::filesystem::path& picture);

/// Throws Error unless the name ends with .svg or .png.
void require_picture(const std::filesystem::path& picture);

}  // namespace hystcan::app
