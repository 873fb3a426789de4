// Identifies a stage with dynamics: the hysteresis model and, behind it, a second-order mode with a delay
// (model/dynamics.h).
//
//   x = H[v],   y = F[x]
//
//   v, x, y   input, output of the hysteresis (quasi-static), measured output
//   H, F      hysteresis and dynamics
//   p         parameters of the dynamics: log of the frequency, log of the damping ratio, delay
//
// The method is Gauss-Newton steps from the quasi-static model. G is nearly the inverse of F
// (identification/quasi_static.h). With x and p of the previous step,
//
//   x + G (y - F x)
//
// is a dataset of the quasi-static output. The best curves, convergence rates, memory and offsets for this
// dataset are found as for any dataset. At the same time, regressors G dF/dp x correct p to first order:
// otherwise the curves would compensate a wrong p. Then p is fitted to y with the new x (Levenberg's method),
// and the next step begins. The first p is the p of the dataset that shows the mode most clearly
// (second_order_fit.h, driven by x).
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::identification {

/// Does the same as identify(), and also identifies the dynamics. Throws std::invalid_argument like
/// identify(), and also if a dataset is not evenly sampled, if no dataset shows a mode, or if the dynamics do
/// not lower the error.
Identified identify_dynamics(const std::vector<Dataset>& datasets, const IdentifyOptions& options);

}  // namespace hystcan::identification
