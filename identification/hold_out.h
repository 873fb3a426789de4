// Selects the samples that are held out together: whole cycles, so that a model predicts unseen cycles, or whole records,
// so that it predicts another session.
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "model/reference_curve.h"

namespace hystcan::identification {

/// Fold 0 is never held out. It contains the first cycles that reach the ends of the input range, because a
/// model is not valid beyond them. The other cycles are assigned in turn to folds 1 to count - 1.
struct Folds {
  std::vector<std::vector<int>> of;  ///< the fold of each sample, per dataset
  int count = 1;                     ///< 1: too few cycles to hold any out
  std::size_t cycles = 0;
};

/// `observed`: input range of all datasets. A cycle goes from one lower turning point to the next; swings
/// below a fiftieth of the range do not count as cycles.
Folds assign_folds(const std::vector<Dataset>& datasets, model::Interval observed);

/// Several datasets: those cycles of dataset i whose inputs lie within those of the others are fold i + 1, the rest is
/// fold 0.
Folds records_as_folds(const std::vector<Dataset>& datasets, model::Interval observed);

}  // namespace hystcan::identification
