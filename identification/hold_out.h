// Which samples are held out together: whole cycles, so that a model is asked for what it has not seen.
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "model/reference_curve.h"

namespace hystcan::identification {

/// Fold 0 is never held out: the first cycles that reach the ends of the input range, beyond which no model
/// is to be asked. The others are dealt in turn to folds 1 to count - 1.
struct Folds {
  std::vector<std::vector<int>> of;  ///< per dataset, of each sample
  int count = 1;                     ///< 1: too few cycles to hold any out
  std::size_t cycles = 0;
};

/// `observed`: inputs of all datasets. A cycle runs from one lower turning point to the next; swings below a
/// fiftieth of the range are no cycles.
Folds deal_into_folds(const std::vector<Dataset>& datasets, model::Interval observed);

}  // namespace hystcan::identification
