// The identified model beside the baselines (baselines.h), all of them fitted to the same samples and judged
// by the same ones.
//
//   fit        fitted to every sample, judged by every sample
//   held out   fitted again without half of the cycles that are not in fold 0 (hold_out.h; those of the odd
//              folds), judged by their samples alone
//
// The second time the identified model keeps order and symmetry, and its thresholds at the observed inputs
// where they were there; k, curves, thresholds, delay and initial memories are found anew. That choice of
// order has seen all samples.
//
// Every baseline is given the same delay, thresholds and initial memory as the identified model, and the
// folded inputs where symmetry is even. Several datasets are one row to it: between two of them it travels
// the inputs that lead to the next one's initial memory, which count nowhere (a virgin memory: nested loops
// around the first input that shrink to nothing).
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
  ErrorNorms fit;                      ///< output units
  std::optional<ErrorNorms> held_out;  ///< of the samples that it has not seen
};

struct Comparison {
  std::vector<ComparisonRow> rows;  ///< the identified model first
  double output_span = 0.0;
  std::size_t samples = 0;
  std::size_t held_out_samples = 0;
  std::size_t cycles = 0;
  std::size_t held_out_cycles = 0;
  std::string no_hold_out;           ///< why there is none; empty where there is
  std::vector<std::string> refused;  ///< baselines that could not be fitted, and why
  bool stopped = false;              ///< by go_on: the rows so far
};

/// Of each dataset, of each sample: it is in an odd fold. All false where nothing can be held out.
std::vector<std::vector<bool>> held_out_samples(const Folds& folds);

/// `identified` from these datasets. `go_on` is asked between one model and the next, and in the search.
/// Samples that `identified` has not seen (IdentifyOptions::unseen) count nowhere.
Comparison compare(const std::vector<Dataset>& datasets, const Identified& identified,
                   const std::function<bool()>& go_on);

}  // namespace hystcan::identification
