// Warnings about setpoints that exceed the limits of their axis.
#pragma once

#include <string>
#include <vector>

#include "config/schema/config.h"

namespace hystcan::config {

/// Returns one line for each range, limit and segment if the setpoints exceed the limits of the axis, or if
/// its drive range extends far beyond the ranges of model and twin: "axis x, setpoint[1]: ...", with the
/// remedy. Not an error: the gate and the supervision enforce the limits while the axis runs, but the axis
/// then does not follow, or it faults.
///
/// Simulates one pass of the reference at rate_Hz, without dynamics except for those of plant_inverse: the
/// inverse of the model gives the drive of each cycle. The drive begins at the lower threshold, where the
/// start-up ends. A jump from level to level counts as a jump, not as a slew. Only the first two million
/// cycles of a reference are examined.
std::vector<std::string> setpoint_warnings(const Config& config);

}  // namespace hystcan::config
