// Fits the linear mapping model to samples: finds the coefficients of its curves by Levenberg's method.
#pragma once

#include "identification/baselines/baseline_models.h"

namespace hystcan::identification {

/// Fits the linear mapping model, starting from the curves of `start`; ignores the convergence rates of
/// `start`, because the linear mapping model has none. The result has the orders and the symmetry of `start`.
/// Its curves are valid (model/validity.h) and rise with at least a thousandth of the mean slope. Throws
/// std::invalid_argument if the curves of `start` are not valid.
BaselineModel fit_linear_mapping(const Samples& samples, const model::HysteresisParameters& start);

}  // namespace hystcan::identification
