// The first files of a stage: a commented configuration and models, derived from the known facts.
#pragma once

#include <optional>
#include <string>

#include "app/stage/stage_facts.h"
#include "model/hysteresis_parameters.h"
#include "model/output_creep.h"

namespace hystcan::app {

/// Returns the text of a configuration. Unknown values are derived from the stroke, the range of the drive
/// and the resonance, and their comments state this. The reference covers 80 % of the travel; the integral
/// gain is cautious for a mode with damping ratio zeta and angular frequency omega:
///
///   ki = zeta omega / 2      a quarter of the gain at which an integrator makes a mode unstable
std::string config_text(const StageFacts& facts);

/// Returns the positions at which a run stops: 15 % of the travel beyond it.
model::Interval position_limits_um(const model::Interval& travel_um);

/// Returns a straight line through the travel: the controller's model until one is measured.
model::HysteresisParameters straight_line(const AxisFacts& axis);

/// Returns a loop with a width of 11 % of the travel, typical of piezo stacks: the twin's model until one is
/// measured.
model::HysteresisParameters usual_loop(const AxisFacts& axis);

/// Returns a deliberately inexact model, so that a rehearsal shows the effect of a wrong model: its outputs
/// are off by at most `share` of half their range, and k_ascending and k_descending by 20/3 of `share`, as
/// far as the model stays valid.
model::HysteresisParameters not_quite(const model::HysteresisParameters& parameters, double share);
/// Increases the creep by 20/3 of `share`, like k_ascending and k_descending, but at most to
/// identification::most_creep_per_decade.
std::optional<model::OutputCreep::Config> not_quite(std::optional<model::OutputCreep::Config> creep,
                                                    double share);

}  // namespace hystcan::app
