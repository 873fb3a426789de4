// Computes warnings about setpoints that exceed the limits of their axis.
#pragma once

#include <string>
#include <vector>

#include "config/schema/config.h"

namespace hystcan::config {

/// Returns a warning for each segment and each limit that the segment exceeds, and for a drive range that
/// extends far beyond the range of model or twin. A warning has place, problem and remedy: "axis x,
/// setpoint[1]: ...". Such a setpoint is not an error, because the controller enforces the limits while the
/// axis runs. But then the axis does not follow the setpoint, or it faults.
///
/// The function simulates one pass of the reference at rate_Hz. The inverse of the hysteresis model gives the
/// drive of each cycle; of the dynamics, only plant_inverse is simulated. The drive begins at the lower
/// end of the model's range of drives, where the start-up ends. A step between two levels counts as a jump
/// and not as a slew. Only the first two million cycles of a reference are examined.
std::vector<std::string> setpoint_warnings(const Config& config);

}  // namespace hystcan::config
