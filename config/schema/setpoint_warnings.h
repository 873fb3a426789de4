// Warnings of setpoints that the limits of their axis do not allow.
#pragma once

#include <string>
#include <vector>

#include "config/schema/config.h"

namespace hystcan::config {

/// Where the setpoints ask for more than the limits of the axis allow, or its drive may go far beyond the
/// ranges of model and twin: one line for each range, limit and segment, "axis x, setpoint[1]: ..., what
/// would do". This is no error: the gate and the supervision keep the limits while the axis runs, but it then
/// does not follow, or it faults.
///
/// One pass of the reference is followed at rate_Hz, without dynamics but for those that plant_inverse feeds
/// forward: the inverse of the model gives the drive of each cycle. The drive begins at the lower threshold,
/// where the start-up ends. A jump from level to level counts as a jump and not as a slew. A reference of
/// more than two million cycles is looked at up to there.
std::vector<std::string> setpoint_warnings(const Config& config);

}  // namespace hystcan::config
