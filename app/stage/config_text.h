// A commented configuration from what is known of a stage.
#pragma once

#include <string>

#include "app/stage/stage_facts.h"

namespace hystcan::app {

/// The text of a configuration. What is not known is derived from the stroke, the range of the drive and the resonance, and
/// its comment says so. The reference covers 80 % of the travel; the integral gain is a cautious one for the mode:
///
///   ki = zeta omega / 2      a quarter of where an integrator alone makes a mode unstable, ki = 2 zeta omega
std::string config_text(const StageFacts& facts);

/// Where a position ends the run: 15 % of the travel beyond it.
model::Interval position_limits_um(const model::Interval& travel_um);

}  // namespace hystcan::app
