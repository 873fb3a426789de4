// Compares the identified model with the baselines (baseline_models.h). All are fitted to the same samples,
// and their errors are computed over the same samples.
//
//   column      fitted to                                                     errors over
//   fit         every sample                                                  every sample
//   held out    every sample except those of the odd folds (dataset.h):       the samples of the odd folds
//               half of the cycles that are not in fold 0
//
// For the held-out column the identified model keeps its order and symmetry; if its thresholds were at the
// observed inputs, they stay there. k, curves, thresholds, delay and initial memories are identified again.
// The order was chosen with all samples.
//
// Every baseline has the same delay, thresholds and initial memory as the identified model, and the folded
// inputs if symmetry is even. Several datasets are joined into one sequence. Between two datasets, the
// sequence contains inputs that lead to the initial memory of the next one; these samples do not count. For a
// virgin memory they are nested loops around the first input that shrink to zero.
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
  ErrorNorms fit;                      ///< errors over every sample, output units
  std::optional<ErrorNorms> held_out;  ///< errors over the held-out samples
};

struct Comparison {
  std::vector<ComparisonRow> rows;  ///< the identified model first
  double output_span = 0.0;
  std::size_t samples = 0;
  std::size_t held_out_samples = 0;
  std::size_t cycles = 0;
  std::size_t held_out_cycles = 0;
  std::optional<std::string> no_hold_out;  ///< reason why nothing is held out; `nullopt` if something is
  std::vector<std::string> refused;        ///< baselines that could not be fitted, with the reason
  bool stopped = false;                    ///< go_on stopped the comparison: `rows` is incomplete
};

/// Returns for each sample, per dataset: true if it is in an odd fold. All false if nothing can be held out.
std::vector<std::vector<bool>> held_out_samples(const Folds& folds);

/// `identified` is the result for these datasets. `go_on` is called between two models, and during the
/// search. Unseen samples of `identified` (IdentifyOptions::unseen) do not count.
Comparison compare(const std::vector<Dataset>& datasets, const Identified& identified,
                   const std::function<bool()>& go_on);

}  // namespace hystcan::identification
