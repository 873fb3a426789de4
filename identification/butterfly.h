// Identification of a butterfly x = g(m), m = H[v] (model/output_map.h) by Gauss-Newton steps. With m and g
// of the previous step,
//
//   z = m + (x - g(m)) / g'(m),  weight |g'(m)|
//
// is a dataset of m: the best curves, k, delay and memory for it are found as for any dataset. Then g is
// fitted to x and the new m, and so on. Each step also corrects g to first order, by regressors T_3 to T_6 of
// m (T_1 and T_2 would only shift and scale m). The first m is derived from the dataset: its size is sqrt(x -
// x_valley), and its sign changes where x passes a valley between two turning points of the input.
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::identification {

/// True if the output passes a valley well inside a swing of the input, away from its turning points.
bool passes_valley(const Dataset& dataset);

/// `curves`: a function that identifies a model without a map. The result has a map; its errors are errors of
/// x. Throws std::invalid_argument if a dataset does not pass a valley, or if `curves` throws it.
Identified identify_butterfly(const std::vector<Dataset>& datasets, const IdentifyOptions& options,
                              const IdentifyDatasets& curves);

/// Returns the datasets of m from the last step, for studies of an identified butterfly.
std::vector<Dataset> linearised(const std::vector<Dataset>& datasets, const Identified& identified);

}  // namespace hystcan::identification
