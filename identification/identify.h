// Identifies an actuator: finds the recursive memory-based model that fits measured datasets best, and
// computes how well it fits.
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
  double delay_s = 0.0;  ///< delay of the input; only for a model without dynamics
  /// Mode and delay behind the hysteresis (dynamics/joint_dynamics.h); `nullopt`: none.
  std::optional<model::Dynamics> dynamics{};
  /// Creep of the actuator: acts on the output of the hysteresis, before the dynamics. `nullopt`: no creep.
  std::optional<model::OutputCreep::Config> creep{};
  std::vector<InitialMemory> memories;  ///< memory of the actuator at the beginning of each dataset
  /// Offset of each dataset's output, relative to the first dataset, output units.
  std::vector<double> offsets;
  std::vector<double> gains;  ///< gain of each dataset's output, relative to the first dataset
  /// Drift of each dataset's output, from its first sample to its last, output units.
  std::vector<double> drifts;
  SearchResult search;
  Folds folds;
  std::vector<Characterisation> datasets;
  /// Errors of the model in each dataset. The prediction includes the offset, gain and drift of the dataset.
  /// The errors include the samples that the fit did not use (IdentifyOptions::unseen).
  std::vector<ErrorNorms> errors;
  ErrorNorms overall;
  std::optional<double> held_out_rms;
  /// Span of the outputs of all datasets, after their offsets and gains are removed. Samples that the fit did
  /// not use (IdentifyOptions::unseen) do not count, except in a butterfly.
  double output_span = 0.0;
  model::Interval observed;
  /// Range of each convergence rate in which the model fits nearly as well as with its own rate; see
  /// pace_range().
  model::Interval pace_ascending, pace_descending;
  /// Range of the creep per decade in which the model fits nearly as well as with its own creep; see
  /// creep_range(). `nullopt` if the creep was given, or if the model has none.
  std::optional<model::Interval> creep_range;
  /// The result of the second search: without creep if this model has creep, with creep if this model has
  /// none. `nullopt` if there was only one search.
  std::optional<SearchResult> alternative;
  /// Gains of the datasets that could explain the outputs instead of creep. `nullopt` if these gains fit
  /// worse than creep, or if the gains were given.
  std::optional<GainsInstead> gains_instead;
  /// For each dataset, its prediction by a fit to the other datasets; empty if there is only one dataset.
  std::vector<LeftOut> left_out;
  /// Range of the delays with which the model fits nearly as well; `nullopt` if the delay was given, or if
  /// the range cannot be determined.
  std::optional<DelayRange> delay_range;
  /// True if go_on stopped the search. The model is then the best result until the stop.
  bool stopped = false;

  /// Returns the number of fitted parameters: curves, convergence rates, thresholds, delay, creep, dynamics
  /// and output map. Parameters of a single dataset, such as its offset, do not count.
  std::size_t parameter_count() const;
  Lag lag() const { return {delay_s, dynamics, creep}; }
  /// Returns offset plus drift of a dataset at one of its rows, in output units.
  double zero_at(std::size_t dataset, std::span<const double> time_s, std::size_t row) const {
    return offsets[dataset] + drifts[dataset] * drift_course(time_s, row);
  }
};

using IdentifyDatasets = std::function<Identified(const std::vector<Dataset>&, const IdentifyOptions&)>;

/// Predicts all datasets and sets `errors` and `overall` of the model.
void judge(Identified& identified, const std::vector<Dataset>& datasets);
/// Sets `output_span` of the model. `unseen`: flags of samples that do not count, as in IdentifyOptions.
void measure_span(Identified& identified, const std::vector<Dataset>& datasets,
                  const std::vector<std::vector<bool>>& unseen = {});

/// Returns the output that the model predicts for dataset i, with its dynamics, offset, gain and drift. The
/// model must have been identified from these datasets.
std::vector<double> predict(const Identified& identified, const std::vector<Dataset>& datasets,
                            std::size_t i);

/// Identifies a model from datasets of one actuator. Throws std::invalid_argument with the reason if nothing
/// can be identified (characterisation.h), if no dataset has a turning point, if the output does not follow
/// the input, or if the samples cannot determine curves of the requested order. If a constant is added to all
/// outputs, the curves move by this constant and nothing else changes (output_reference.h).
Identified identify(const std::vector<Dataset>& datasets, IdentifyOptions options);

}  // namespace hystcan::identification
