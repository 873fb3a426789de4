// Opens the cards that [axis.analogue] names.
#pragma once

#include <vector>

#include "can/scheduler.h"
#include "config/schema/config.h"
#include "node/analogue/analogue_station.h"

namespace hystcan::app {

/// Opens a real card, or the simulated one with the stages of `axes`. Refers to its arguments.
node::Cards::Open card_opener(const config::Config& config, const std::vector<node::WiredAnalogueAxis>& axes,
                              can::Scheduler& scheduler);

}  // namespace hystcan::app
