// What no setpoints can avoid: the floor of the true error (controller/analysis/feed_forward_design.h) of a
// reference on a stage.
#pragma once

#include <optional>
#include <vector>

#include "controller/reference/trajectory.h"
#include "twin/twin.h"

namespace hystcan::app {

/// um RMS of each segment; none where it has no floor, or the stage a second mode.
std::vector<std::optional<double>> tracking_floors_um(const twin::AxisConfig& stage,
                                                      const std::vector<controller::Segment>& setpoint,
                                                      double cycle_s);

}  // namespace hystcan::app
