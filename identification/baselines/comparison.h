// Compares the identified model with the baselines (baseline_models.h). All models are fitted to the same
// samples, and their errors are computed over the same samples.
//
//   column      fitted to                                                     errors over
//   fit         every sample                                                  every sample
//   held out    every sample except those of the odd folds (dataset.h):       the samples of the odd folds
//               half of the cycles that are not in fold 0
//
// For the held-out column, the model is identified again. It keeps its order and symmetry, which were chosen
// with all samples. If its thresholds were the ends of the observed inputs, they stay there. Everything else
// is identified again: convergence rates, curves, other thresholds, delay and initial memories.
//
// Every baseline has the delay, the thresholds and the initial memory of the identified model. If symmetry is
// even, its inputs are folded. Several datasets are joined into one sequence. Between two datasets, the
// sequence contains inputs that lead to the initial memory of the next dataset; these inputs do not count as
// samples. If this memory is virgin, these inputs are nested loops around the first input, which shrink to
// zero.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identification/dataset.h"
#include "identification/identify.h"
#include "identification/prediction.h"

namespace hystcan::identification {

struct ComparisonRow {
  std::string name;
  std::size_t parameters = 0;
  ErrorNorms fit;  ///< errors over all samples, output units
  /// Errors over the samples that were not fitted, output units; `nullopt`: nothing was held out.
  std::optional<ErrorNorms> held_out;
};

struct Comparison {
  std::vector<ComparisonRow> rows;  ///< the identified model, then the baselines
  double output_span = 0.0;
  std::size_t samples = 0;
  std::size_t held_out_samples = 0;
  std::size_t cycles = 0;
  std::size_t held_out_cycles = 0;
  /// Reason why no samples are held out; `nullopt` if some are held out.
  std::optional<std::string> no_hold_out;
  std::vector<std::string> refused;  ///< for each baseline that could not be fitted, the reason
  /// True if go_on stopped the comparison; `rows` is then incomplete.
  bool stopped = false;
};

/// Returns a flag for each sample of each dataset: true if the sample is in an odd fold. If nothing can be
/// held out, all flags are false.
std::vector<std::vector<bool>> held_out_samples(const Folds& folds);

/// Compares the identified model with the baselines. `identified` must be the result for these `datasets`.
/// `go_on` is called between two models and during the search; if it returns false, the comparison stops.
/// Samples that were unseen when the model was identified (IdentifyOptions::unseen) do not count.
Comparison compare(const std::vector<Dataset>& datasets, const Identified& identified,
                   const std::function<bool()>& go_on);

}  // namespace hystcan::identification
