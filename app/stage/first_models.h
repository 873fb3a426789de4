// Models for a stage that has none, and a twin's model that is not quite the controller's.
#pragma once

#include "app/stage/stage_facts.h"
#include "model/hysteresis_parameters.h"

namespace hystcan::app {

/// A straight line through the travel: the controller's model until there is a measured one.
model::HysteresisParameters straight_line(const AxisFacts& axis);

/// A loop of 11 % of the travel, as piezo stacks have: the twin's model until there is a measured one.
model::HysteresisParameters usual_loop(const AxisFacts& axis);

/// The model with curves 3 % and k 20 % off, where it stays valid with that, so that a rehearsal shows what a controller
/// makes of a model that is not quite true.
model::HysteresisParameters not_quite(const model::HysteresisParameters& parameters);

}  // namespace hystcan::app
