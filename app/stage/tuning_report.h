// The result of `hystcan tune` as text, as a fragment of a configuration and as JSON. Also the frequency
// response of the experiment, of the identified mode and of two loops, as a table and as a picture.
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

/// One setting of the loop of an axis, and its predicted effect.
struct Candidate {
  std::string name;                                ///< "present", "plain", "low pass", "notch", "cautious"
  controller::LoopConfig loop;                     ///< includes the delays of the feed-forward
  std::optional<controller::JudgedLoop> judged{};  ///< empty if ki is zero, because there is no loop to judge
  /// Prediction for the configured reference, with the configured structure and limits, without learning;
  /// empty if the loop is not stable and was therefore not rehearsed.
  std::optional<controller::AxisOutcome> predicted{};
  std::optional<double> true_rms_um{};  ///< from the same run, including the error between the samples;
                                        ///< empty: not known
  /// Predictions without following-error limit, by all_structures; only for the present and the proposed
  /// candidate.
  std::vector<controller::AxisOutcome> by_structure{};

  bool has_run() const;
  double rms_percent() const;  ///< in percent of the stroke
};

/// Returns the index of the candidate with the smallest predicted error at the samples, among the candidates
/// whose sensitivity is at most `peak_sensitivity` at all corners of the plant's uncertainty. The present
/// setting (index 0) is chosen unless another candidate is better by 2 % at the samples and, if known, not
/// worse between the samples.
std::size_t best_of(const std::vector<Candidate>& candidates, double peak_sensitivity);

struct TuningReport {
  std::string config;  ///< file name without its folder
  std::string axis;
  std::string drive_unit;
  std::string actuator;  ///< model file of the twin
  std::string record;    ///< file name without its folder; empty: an experiment with these steps
  bool rehearsed = false;
  controller::Excitation::Steps steps;
  double rate_Hz = 0.0;
  IdentifiedPlant plant;
  controller::SensitivityRule rule{};
  controller::CautiousRule cautious_rule{};
  bool only_cautious = false;
  std::vector<Candidate> candidates;  ///< the first one is the present setting
  std::size_t best = 0;
  double unshared_s = 0.0;           ///< measured delay of amplifier and sensor together; 0 if the
                                     ///< configuration states the sensor's delay
  std::optional<Promise> promise{};  ///< promise of the proposed loop; empty: not requested
  std::optional<RateOffer> offer{};  ///< a better rate, with a cautious loop

  const Candidate& present() const { return candidates.front(); }
  const Candidate& proposed() const { return candidates[best]; }
};

/// Returns the uncertainty that remains after the experiment. A report without an experiment uses the stated mode.
Uncertainty uncertainty_of(const TuningReport& report);

std::string describe(const TuningReport& report);
/// Returns the keys of [axis.control] to replace, each with its present value in a comment.
std::string fragment(const TuningReport& report);
nlohmann::json to_json(const TuningReport& report);

/// Returns CSV with a row for each measured frequency. Gains of plant and model are normalised to 1 at rest.
/// Phases are in degrees; those of the loops start near -90 and are unwrapped.
std::string response_table(const TuningReport& report, const identification::Dataset& record);

/// Draws `picture` (.svg or .png). Its data stay in the same folder: the response_table(), followed by rows
/// of the curves (.data.csv), and the list (.json, pictures.h). Returns the reason if there is no picture.
std::optional<std::string> draw_response(const TuningReport& report, const identification::Dataset& record,
                                         const std::filesystem::path& picture);

/// Throws Error unless the name ends with .svg or .png.
void require_picture(const std::filesystem::path& picture);

}  // namespace hystcan::app
