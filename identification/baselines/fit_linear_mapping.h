// Fits the linear mapping model with Levenberg's method on the coefficients of its curves.
#pragma once

#include "identification/baselines/baseline_models.h"

namespace hystcan::identification {

/// Applies Levenberg's method, starting from the curves of `start`; ignores k. The fit keeps the orders and
/// the symmetry of `start`. The curves stay valid (model/validity.h) and rise everywhere with at least a
/// thousandth of the mean slope. Throws std::invalid_argument if the curves of `start` are not valid.
BaselineModel fit_linear_mapping(const Samples& samples, const model::HysteresisParameters& start);

}  // namespace hystcan::identification
