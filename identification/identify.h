// Identification: finds the recursive memory-based model that fits measured datasets best, and its figures.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identification/characterisation.h"
#include "identification/hold_out.h"
#include "identification/prediction.h"
#include "identification/search.h"

namespace hystcan::identification {

struct IdentifyOptions {
  std::optional<int> order;                 ///< of the reference curves; none: chosen by hold-out
  std::optional<model::Symmetry> symmetry;  ///< none: determined from the dataset
  bool observed_thresholds = false;         ///< thresholds at the ends of the observed input range
  std::size_t search_samples = 3000;        ///< samples that the search uses; the last fit uses all
  std::function<bool()> go_on;              ///< returns false: stop with the best so far; none: never stop
  /// A flag for each sample, per dataset. The fit does not use the output of an unseen sample, but it applies
  /// its input. Empty: no sample is unseen.
  std::vector<std::vector<bool>> unseen;
};

/// The range of one k in which the RMS is within 5 % of the best. 1 / input unit.
struct PaceRange {
  double lo = 0.0;
  double hi = 0.0;
  bool is_fixed = true;  ///< false: wider than a factor of ten, or k = 0 is also good
};

struct Identified {
  model::HysteresisParameters parameters;
  double delay_s = 0.0;
  std::vector<InitialMemory> memories;  ///< for each dataset
  SearchResult search;
  Folds folds;
  std::vector<Characterisation> datasets;
  std::vector<ErrorNorms> misses;  ///< errors for each dataset, over all samples, also unseen ones
  ErrorNorms overall;
  std::optional<double> held_out_rms;
  double output_span = 0.0;  ///< over all datasets, without unseen samples
  model::Interval observed;
  PaceRange pace_ascending, pace_descending;
  bool stopped = false;  ///< go_on stopped the search; this is the best so far

  std::size_t parameter_count() const;  ///< curves, k, thresholds, delay; without initial memories
};

/// Throws std::invalid_argument with the reason if nothing can be identified (characterisation.h), if the
/// output does not follow the input, or if the samples cannot determine curves of the requested order.
Identified identify(const std::vector<Dataset>& datasets, const IdentifyOptions& options);

/// RMS of the best curves for each pair of k, output units. All other values are as identified.
struct Landscape {
  std::vector<double> k_ascending, k_descending;
  std::vector<std::vector<double>> rms;  ///< [descending][ascending]
};
Landscape landscape(const std::vector<Dataset>& datasets, const Identified& identified, int points);

}  // namespace hystcan::identification
