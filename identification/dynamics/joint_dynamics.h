// Identification of a stage with dynamics: y = F[x], x = H[v] (model/dynamics.h): Gauss-Newton steps from the
// quasi-static model. With x and p = (log f, log zeta, d) from before and G nearly the inverse of F
// (identification/quasi_static.h),
//
//   x + G (y - F x)
//
// is a dataset of the quasi-static output: the best curves, k, memory and zeros for it are found as for any
// dataset. Regressors G dF/dp x correct p to first order at the same time, so that curves do not make up for
// a wrong p. Then p is fitted to y and the new x (Levenberg), and so on. The first p is that of the dataset
// that shows the mode best (second_order_fit.h, driven by x).
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::identification {

/// As identify(), with dynamics. Throws std::invalid_argument also if a dataset is not evenly sampled, if
/// none shows the mode, or if the dynamics do not lower the error.
Identified identify_dynamics(const std::vector<Dataset>& datasets, const IdentifyOptions& options);

}  // namespace hystcan::identification
