// Identification of a stage with dynamics: y = F[x], x = H[v] (model/dynamics.h), by Gauss-Newton steps from
// the quasi-static model. With x and p = (log f, log zeta, d) of the previous step, and G nearly the inverse
// of F (identification/quasi_static.h),
//
//   x + G (y - F x)
//
// is a dataset of the quasi-static output: the best curves, k, memory and zeros for it are found as for any
// dataset. At the same time, regressors G dF/dp x correct p to first order, so that the curves do not
// compensate a wrong p. Then p is fitted to y and the new x (Levenberg), and so on. The first p is the p of
// the dataset that shows the mode best (second_order_fit.h, driven by x).
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::identification {

/// Same as identify(), with dynamics. Also throws std::invalid_argument if a dataset is not evenly sampled,
/// if none shows the mode, or if the dynamics do not lower the error.
Identified identify_dynamics(const std::vector<Dataset>& datasets, const IdentifyOptions& options);

}  // namespace hystcan::identification
