// Formats the result of `hystcan tune` as text, as a fragment of a configuration and as JSON. Also writes
// frequency responses as a table and a picture: of the experiment, of the identified plant, of the present
// loop and of the proposed loop.
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

/// One possible setting of the loop of an axis, with its judged stability and its predicted error.
struct Candidate {
  std::string name;                                ///< "present", "plain", "low pass", "notch" or "cautious"
  controller::LoopConfig loop;                     ///< gains, filters, and the delays of the feed-forward
  std::optional<controller::JudgedLoop> judged{};  ///< stability; nullopt if ki is zero, because there is no
                                                   ///< loop
  /// Outcome of a rehearsal with the configured reference, limits and structure of the control law, but
  /// without learning (repetitive control). `nullopt` if the loop is not stable enough for a rehearsal.
  std::optional<controller::AxisOutcome> predicted{};
  std::optional<double> true_rms_um{};  ///< true RMS error of this rehearsal: at and between the samples
  /// Outcomes of rehearsals with each structure of the control law, in the order of
  /// controller::all_structures. Set only for the present and the proposed candidate.
  std::vector<controller::AxisOutcome> by_structure{};

  bool has_run() const;
  double rms_percent() const;  ///< predicted RMS error at the samples, in percent of the stroke
};

/// Returns the index of the best candidate: it has the smallest predicted error at the samples, and its
/// sensitivity is at most `peak_sensitivity` at every corner of the plant's uncertainty (a combination of the
/// ends of its intervals). The best candidate must also be better than the present setting (index 0) by 2 %
/// at the samples and, if known, not worse between the samples; otherwise the present setting is the best.
std::size_t best_of(const std::vector<Candidate>& candidates, double peak_sensitivity);

struct TuningReport {
  std::string config;  ///< name of the configuration file, without its folder
  std::string axis;
  std::string drive_unit;
  std::string actuator;  ///< model file of the twin's actuator
  std::string record;    ///< name of the record file; empty: the command itself drove `steps`
  bool rehearsed = false;
  controller::Excitation::Steps steps;
  double rate_Hz = 0.0;
  IdentifiedPlant plant;
  controller::SensitivityRule rule{};
  controller::CautiousRule cautious_rule{};
  bool only_cautious = false;
  std::vector<Candidate> candidates;  ///< the first candidate is the present setting
  std::size_t best = 0;
  double unshared_s = 0.0;           ///< delay of amplifier and sensor together if the sensor's share is not
                                     ///< known; 0: the sensor's delay is stated
  std::optional<Promise> promise{};  ///< promise for the proposed loop; nullopt: not computed
  std::optional<RateOffer> offer{};  ///< better cycle rate, with promises for a cautious loop at this rate

  const Candidate& present() const { return candidates.front(); }
  const Candidate& proposed() const { return candidates[best]; }
};

/// Returns which dynamics are still uncertain after the experiment. If no experiment was made, the resonance
/// has the uncertainty of a stated resonance.
Uncertainty uncertainty_of(const TuningReport& report);

std::string describe(const TuningReport& report);
/// Returns lines with the keys of [axis.control] to change. The comment after each key has its present value.
std::string fragment(const TuningReport& report);
nlohmann::json to_json(const TuningReport& report);

/// Returns a CSV table with a row for each measured frequency. The gains of measurement and model are
/// relative to the gain at rest. The columns `before_...` and `after_...` have the frequency response of the
/// open control loop with the present and with the proposed setting. Phases are in degrees without jumps of
/// 360; the phases of the open loops start near -90.
std::string response_table(const TuningReport& report, const identification::Dataset& record);

/// Draws the frequency responses to the file `picture` (.svg or .png). Writes two more files beside the
/// picture: the data as .data.csv (the rows of response_table() and of the curves), and the list of pictures
/// as .json (pictures.h). Returns the reason if the picture was not drawn.
std::optional<std::string> draw_response(const TuningReport& report, const identification::Dataset& record,
                                         const std::filesystem::path& picture);

/// Throws Error if the name of the picture does not end with .svg or .png.
void require_picture(const std::filesystem::path& picture);

}  // namespace hystcan::app
