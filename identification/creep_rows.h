// Creep behind the hysteresis, row by row (model/held_creep.h).
#pragma once

#include <optional>
#include <vector>

#include "model/held_creep.h"

namespace hystcan::identification {

/// The outputs of an actuator whose hysteresis has these outputs. It begins settled, or in `start`.
std::vector<double> with_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                               std::vector<double> outputs,
                               const std::optional<model::HeldCreep::State>& start = {});

/// The outputs of the hysteresis of an actuator that has these outputs and begins settled. `counts[i]` false: the output of
/// a row is unknown, and its time does not pass. Empty: all count.
std::vector<double> without_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                                  std::vector<double> outputs, const std::vector<bool>& counts = {});

}  // namespace hystcan::identification
