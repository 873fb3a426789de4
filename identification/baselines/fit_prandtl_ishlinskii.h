// Fits Prandtl-Ishlinskii models to samples: either only the weights of the plays, or also their initial
// values.
#pragma once

#include <cstddef>

#include "identification/baselines/baseline_models.h"

namespace hystcan::identification {

/// Fits the weights of `plays` play operators, at least one. The values of the plays at the first sample
/// follow from inputs that are assumed before it. Several such input sequences are tried (see
/// baseline_models.h), and the best fit is returned.
BaselineModel fit_prandtl_ishlinskii(const Samples& samples, std::size_t plays);

/// Fits the weights and the initial values of the plays together, by Levenberg's method. Starts from the best
/// result of the fit of the weights alone.
BaselineModel fit_prandtl_ishlinskii_free_start(const Samples& samples, std::size_t plays);

}  // namespace hystcan::identification
