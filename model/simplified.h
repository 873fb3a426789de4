// Models without memory, made from the reference curves: what the full model is compared with.
//
// Both are hysteresis models whose ascending and descending reference curves coincide, so that every branch
// lies on the one curve and nothing needs to be remembered.
#pragma once

#include "model/hysteresis_parameters.h"

namespace hystcan::model {

/// The paper's average model: the mean of the two reference curves, (f_0^A + f_0^D) / 2.
HysteresisParameters average(const HysteresisParameters& parameters);

/// The straight line from the lower convergence point to the upper threshold point.
HysteresisParameters straight_line(const HysteresisParameters& parameters);

}  // namespace hystcan::model
