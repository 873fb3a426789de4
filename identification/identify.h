// From measured datasets to a model: the recursive memory-based model that fits them best, and what there is
// to say of it.
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
  std::optional<model::Symmetry> symmetry;  ///< none: even where the dataset is
  bool observed_thresholds = false;         ///< thresholds at the ends of the observed input range
  std::size_t search_samples = 3000;        ///< that the search looks at; the last fit looks at all
  std::function<bool()> go_on;              ///< false: stop with the best so far; none: never
  /// Per dataset, of each sample: true, and the fit does not see its output; its input is travelled all the
  /// same. Empty: all are seen.
  std::vector<std::vector<bool>> unseen;
};

/// Where one k lies as well as anywhere: RMS within 5 % of the best. 1 / input unit.
struct PaceRange {
  double lo = 0.0;
  double hi = 0.0;
  bool is_fixed = true;  ///< false: wider than a factor of ten, or k = 0 would do
};

struct Identified {
  model::HysteresisParameters parameters;
  double delay_s = 0.0;
  std::vector<InitialMemory> memories;  ///< of each dataset
  SearchResult search;
  Folds folds;
  std::vector<Characterisation> datasets;
  std::vector<ErrorNorms> misses;  ///< of each dataset, all its samples, unseen ones too
  ErrorNorms overall;
  std::optional<double> held_out_rms;
  double output_span = 0.0;  ///< of all datasets together, of the samples seen
  model::Interval observed;
  PaceRange pace_ascending, pace_descending;
  bool stopped = false;  ///< by go_on: the best so far

  std::size_t parameter_count() const;  ///< of curves, k, thresholds, delay; initial memories not counted
};

/// Throws std::invalid_argument where nothing can be identified, with the reason (characterisation.h); where
/// the output does not follow the input; where an order is asked for that the samples can't tell.
Identified identify(const std::vector<Dataset>& datasets, const IdentifyOptions& options);

/// RMS of the best curves at each pair of k, the rest as identified: rows of k_descending. Output units.
struct Landscape {
  std::vector<double> k_ascending, k_descending;
  std::vector<std::vector<double>> rms;  ///< [descending][ascending]
};
Landscape landscape(const std::vector<Dataset>& datasets, const Identified& identified, int points);

}  // namespace hystcan::identification
