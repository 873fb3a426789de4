// Opens the data acquisition cards named in [axis.analogue].
#pragma once

#include <vector>

#include "can/scheduler.h"
#include "config/schema/config.h"
#include "node/analogue/analogue_station.h"

namespace hystcan::app {

/// Returns a function that opens the card with a given device name: a real card, or the simulated card, which
/// is connected to simulated stages of `axes`. All three arguments must outlive the returned function.
node::Cards::Open card_opener(const config::Config& config, const std::vector<node::WiredAnalogueAxis>& axes,
                              can::Scheduler& scheduler);

}  // namespace hystcan::app
