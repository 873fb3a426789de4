// Opens the cards named in [axis.analogue].
#pragma once

#include <vector>

#include "can/scheduler.h"
#include "config/schema/config.h"
#include "node/analogue/analogue_station.h"

namespace hystcan::app {

/// Returns a function that opens a real card, or the simulated card with the stages of `axes`. The arguments
/// must outlive it.
node::Cards::Open card_opener(const config::Config& config, const std::vector<node::WiredAnalogueAxis>& axes,
                              can::Scheduler& scheduler);

}  // namespace hystcan::app
