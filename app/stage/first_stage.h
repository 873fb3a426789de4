// Creates the first files of a stage from the known facts: a commented configuration and provisional models.
#pragma once

#include <optional>
#include <string>

#include "app/stage/stage_facts.h"
#include "model/hysteresis_parameters.h"
#include "model/output_creep.h"

namespace hystcan::app {

/// Returns the text of a configuration. Values that nobody stated are derived from the stroke, the drive
/// range and the resonance; their comments say so. The reference covers 80 % of the travel. The integral gain
/// is cautious for a mode with damping ratio zeta and angular frequency omega:
///
///   ki = zeta omega / 2      a quarter of the gain at which an integrator makes a mode unstable; ki is
///                            limited to 0.1 of the cycle rate
std::string config_text(const StageFacts& facts);

/// Returns the positions at which a run is stopped. They are 15 % of the travel beyond its ends.
model::Interval position_limits_um(const model::Interval& travel_um);

/// Returns a model without hysteresis: a straight line through the travel. The controller uses it until a
/// model was measured.
model::HysteresisParameters straight_line(const AxisFacts& axis);

/// Returns a model whose loop has a width of 11 % of the travel, typical of piezo stacks. The twin uses it
/// until a model was measured.
model::HysteresisParameters usual_loop(const AxisFacts& axis);

/// Returns a deliberately inexact model for the twin, so that a rehearsal shows the effect of model errors.
/// Its outputs differ by at most `share` of half their range. Its convergence rates k_ascending and
/// k_descending grow by 20/3 times `share`: if `share` is 3 %, they grow by 20 %. They grow less if the model
/// would become invalid.
model::HysteresisParameters not_quite(const model::HysteresisParameters& parameters, double share);
/// Returns a deliberately inexact creep for the twin. The creep per decade grows by 20/3 times `share`, the
/// share for the model's outputs (see above), but at most to identification::most_creep_per_decade.
std::optional<model::OutputCreep::Config> not_quite(std::optional<model::OutputCreep::Config> creep,
                                                    double share);

}  // namespace hystcan::app
