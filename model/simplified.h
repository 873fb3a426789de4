// Models without memory, made from the reference curves. The full model is compared with them.
//
// Both are hysteresis models whose ascending and descending reference curves coincide. Every branch lies on
// this curve, so that no memory is needed.
#pragma once

#include "model/hysteresis_parameters.h"

namespace hystcan::model {

/// The paper's average model: the mean of the two reference curves, (f_0^A + f_0^D) / 2.
HysteresisParameters average(const HysteresisParameters& parameters);

/// The straight line from the lower convergence point to the upper threshold point.
HysteresisParameters straight_line(const HysteresisParameters& parameters);

}  // namespace hystcan::model
