// Fits Prandtl-Ishlinskii models: only the weights, or weights and initial plays together.
#pragma once

#include <cstddef>

#include "identification/baselines/baseline_models.h"

namespace hystcan::identification {

/// Fits only the weights. `plays`: number of play operators, at least one.
BaselineModel fit_prandtl_ishlinskii(const Samples& samples, std::size_t plays);

/// Applies Levenberg's method to weights and initial plays, starting from the best fit of the histories.
BaselineModel fit_prandtl_ishlinskii_free_start(const Samples& samples, std::size_t plays);

}  // namespace hystcan::identification
