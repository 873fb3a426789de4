// Finds the recursive memory-based model that fits measured datasets best, and its figures.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "identification/characterisation.h"
#include "identification/dataset.h"
#include "identification/determination.h"
#include "identification/prediction.h"
#include "identification/search.h"
#include "model/dynamics.h"

namespace hystcan::identification {

struct Identified {
  model::HysteresisParameters parameters;
  double delay_s = 0.0;                               ///< delay of a quasi-static model
  std::optional<model::Dynamics> dynamics{};          ///< behind the hysteresis (dynamics/joint_dynamics.h)
  std::optional<model::OutputCreep::Config> creep{};  ///< between hysteresis and dynamics
  std::vector<InitialMemory> memories;                ///< for each dataset
  std::vector<double> offsets;  ///< offset of each dataset's output, output units; zero for the first dataset
  std::vector<double> gains;    ///< gain of each dataset's output; 1 for the first dataset
  std::vector<double> drifts;   ///< from a dataset's first sample to its last, output units
  SearchResult search;
  Folds folds;
  std::vector<Characterisation> datasets;
  /// Errors for each dataset, with its offset, gain and drift; includes unseen samples.
  std::vector<ErrorNorms> errors;
  ErrorNorms overall;
  std::optional<double> held_out_rms;
  /// Span of the outputs of all datasets, with zero and gain of the first dataset, without unseen samples.
  double output_span = 0.0;
  model::Interval observed;
  model::Interval pace_ascending, pace_descending;  ///< good values of each k (pace_range())
  /// Good values of the creep per decade (creep_range()); `nullopt`: the creep was given, or there is none.
  std::optional<model::Interval> creep_range;
  /// Result of the search without creep if this model has creep, and with creep if it has none.
  std::optional<SearchResult> alternative;
  /// Gains that could explain the datasets instead of creep; `nullopt`: the gains fit worse, or are given.
  std::optional<GainsInstead> gains_instead;
  std::vector<LeftOut> left_out;          ///< each dataset, predicted by the others; empty: there is only one
  std::optional<DelayRange> delay_range;  ///< `nullopt`: the delay was given, or cannot be determined
  bool stopped = false;                   ///< go_on stopped the search: this is the best result so far

  /// Returns the number of parameters in curves, k, thresholds, delay and dynamics, without those that belong
  /// to a single dataset.
  std::size_t parameter_count() const;
  Lag lag() const { return {delay_s, dynamics, creep}; }
  /// Returns zero plus drift of a dataset at one of its rows.
  double zero_at(std::size_t dataset, std::span<const double> time_s, std::size_t row) const {
    return offsets[dataset] + drifts[dataset] * drift_course(time_s, row);
  }
};

using IdentifyDatasets = std::function<Identified(const std::vector<Dataset>&, const IdentifyOptions&)>;

/// Sets `errors` and `overall` from the predictions.
void judge(Identified& identified, const std::vector<Dataset>& datasets);
/// Sets `output_span`. `unseen`: same as in IdentifyOptions.
void measure_span(Identified& identified, const std::vector<Dataset>& datasets,
                  const std::vector<std::vector<bool>>& unseen = {});

/// Returns the model's prediction of a dataset from which it was identified, with its dynamics, offset, gain
/// and drift.
std::vector<double> predict(const Identified& identified, const std::vector<Dataset>& datasets,
                            std::size_t i);

/// Throws std::invalid_argument with the reason if nothing can be identified (characterisation.h), if no
/// dataset has a turning point, if the output does not follow the input, or if the samples cannot determine
/// curves of the requested order. An offset of the outputs shifts the curves and changes nothing else
/// (output_reference.h).
Identified identify(const std::vector<Dataset>& datasets, IdentifyOptions options);

}  // namespace hystcan::identification
