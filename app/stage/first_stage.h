// What a stage begins with: a commented configuration and models from what is known of it.
#pragma once

#include <optional>
#include <string>

#include "app/stage/stage_facts.h"
#include "model/hysteresis_parameters.h"
#include "model/output_creep.h"

namespace hystcan::app {

/// The text of a configuration. What is not known is derived from the stroke, the range of the drive and the
/// resonance, and its comment says so. The reference covers 80 % of the travel; the integral gain is a
/// cautious one for the mode:
///
///   ki = zeta omega / 2      a quarter of where an integrator alone makes a mode unstable, ki = 2 zeta omega
std::string config_text(const StageFacts& facts);

/// Where a position ends the run: 15 % of the travel beyond it.
model::Interval position_limits_um(const model::Interval& travel_um);

/// A straight line through the travel: the controller's model until there is a measured one.
model::HysteresisParameters straight_line(const AxisFacts& axis);

/// A loop of 11 % of the travel, as piezo stacks have: the twin's model until there is a measured one.
model::HysteresisParameters usual_loop(const AxisFacts& axis);

/// The model with outputs off by this share of half their range at most, and k by 20/3 of the share, where it
/// stays valid with that, so that a rehearsal shows what a controller makes of a model that is not quite
/// true.
model::HysteresisParameters not_quite(const model::HysteresisParameters& parameters, double share);
/// The creep off by as much as k, up to identification::most_creep_per_decade.
std::optional<model::OutputCreep::Config> not_quite(std::optional<model::OutputCreep::Config> creep,
                                                    double share);

}  // namespace hystcan::app
