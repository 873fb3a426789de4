// Models without memory, most of them made from the reference curves. The full model is compared with them.
//
// All are hysteresis models whose ascending and descending reference curves coincide. Every branch lies on
// this curve, so that no memory is needed.
#pragma once

#include <string>

#include "model/hysteresis_parameters.h"

namespace hystcan::model {

/// The paper's average model: the mean of the two reference curves, (f_0^A + f_0^D) / 2.
HysteresisParameters average(const HysteresisParameters& parameters);

/// The straight line from the lower convergence point to the upper threshold point.
HysteresisParameters straight_line(const HysteresisParameters& parameters);

/// The straight line from the lowest output at the lowest input to the highest at the highest, where nothing else is known.
HysteresisParameters straight_line(const std::string& input_unit, const std::string& output_unit,
                                   Interval input, Interval output);

}  // namespace hystcan::model
