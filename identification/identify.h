// Identification: finds the recursive memory-based model that fits measured datasets best, and its figures.
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
  double delay_s = 0.0;                               ///< of a quasi-static model
  std::optional<model::Dynamics> dynamics{};          ///< behind the hysteresis (dynamics/joint_dynamics.h)
  std::optional<model::OutputCreep::Config> creep{};  ///< between hysteresis and dynamics
  std::vector<InitialMemory> memories;                ///< for each dataset
  std::vector<double> offsets;  ///< of each dataset's output, output units; that of the first is zero
  std::vector<double> gains;    ///< of each dataset's output; that of the first is 1
  std::vector<double> drifts;   ///< from a dataset's first sample to its last, output units
  SearchResult search;
  Folds folds;
  std::vector<Characterisation> datasets;
  std::vector<ErrorNorms>
      misses;  ///< for each dataset, with its offset, gain and drift; also of unseen samples
  ErrorNorms overall;
  std::optional<double> held_out_rms;
  double output_span = 0.0;  ///< over all datasets, in the first one's zero and gain, without unseen samples
  model::Interval observed;
  model::Interval pace_ascending, pace_descending;  ///< determination.h
  std::optional<model::Interval> creep_range;       ///< per decade; none: it was given, or there is none
  std::optional<SearchResult> other;                ///< with creep if the result has none, without if it has
  std::optional<GainsInstead> gains_instead;        ///< of the creep; none: they miss more, or are given
  std::vector<LeftOut> left_out;          ///< each dataset, predicted by the others; empty: only one
  std::optional<DelayRange> delay_range;  ///< none: the delay was given, or no delay can be determined
  bool stopped = false;                   ///< go_on stopped the search; this is the best so far

  /// Curves, k, thresholds, delay, dynamics; not what each dataset has of its own.
  std::size_t parameter_count() const;
  Lag lag() const { return {delay_s, dynamics, creep}; }
  /// Zero and drift of a dataset at one of its rows.
  double zero_at(std::size_t dataset, std::span<const double> time_s, std::size_t row) const {
    return offsets[dataset] + drifts[dataset] * drift_course(time_s, row);
  }
};

using IdentifyDatasets = std::function<Identified(const std::vector<Dataset>&, const IdentifyOptions&)>;

/// Sets `misses` and `overall` from the predictions.
void judge(Identified& identified, const std::vector<Dataset>& datasets);
/// Sets `output_span`. `unseen`: as in IdentifyOptions.
void measure_span(Identified& identified, const std::vector<Dataset>& datasets,
                  const std::vector<std::vector<bool>>& unseen = {});

/// The model's prediction of a dataset that it was identified from, with its dynamics, offset, gain and
/// drift.
std::vector<double> predict(const Identified& identified, const std::vector<Dataset>& datasets,
                            std::size_t i);

/// Throws std::invalid_argument with the reason if nothing can be identified (characterisation.h), if no
/// dataset has a turning point, if the output does not follow the input, or if the samples cannot determine
/// curves of the requested order. An offset of the outputs moves the curves and changes nothing else
/// (output_reference.h).
Identified identify(const std::vector<Dataset>& datasets, IdentifyOptions options);

}  // namespace hystcan::identification
