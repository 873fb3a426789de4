// Identifies a butterfly: an actuator whose output x is a map g of an inner variable m with hysteresis
// (model/output_map.h).
//
//   x = g(m),   m = H[v]        v: input,  H: hysteresis model
//
// The method is Gauss-Newton steps. With m and g of the previous step, the map is linearised,
//
//   z = m + (x - g(m)) / g'(m),  weight |g'(m)|
//
// z is a dataset of m: the best curves, convergence rates, delay and memory for it are found as for any
// dataset. Then g is fitted to x with the new m, and the next step begins. Each step also corrects g to first
// order, by regressors: the Chebyshev polynomials T_3 to T_6 of m (T_1 and T_2 would only shift and scale m).
// The first m is derived from the dataset: its size is sqrt(x - x_valley), and its sign changes where x
// passes a valley between two turning points of the input.
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::identification {

/// Returns true if the output passes a valley while the input swings from one turning point to the next, well
/// away from both.
bool passes_valley(const Dataset& dataset);

/// Identifies a butterfly. `curves` is the function that identifies a model without an output map. The result
/// has an output map, and its errors are errors of the output. Throws std::invalid_argument if a dataset does
/// not pass a valley, or if `curves` throws it.
Identified identify_butterfly(const std::vector<Dataset>& datasets, const IdentifyOptions& options,
                              const IdentifyDatasets& curves);

/// Returns one dataset of the inner variable m for each dataset of the output x, with the map x = g(m) of the
/// identified butterfly. The map is linearised at the predicted m, as in a step of the identification. The
/// comparison with the baselines needs these datasets.
std::vector<Dataset> linearised(const std::vector<Dataset>& datasets, const Identified& identified);

}  // namespace hystcan::identification
