// Creep behind the hysteresis (model/output_creep.h), row by row: it begins settled.
#pragma once

#include <vector>

#include "model/output_creep.h"

namespace hystcan::identification {

/// The outputs of an actuator whose hysteresis has these outputs.
std::vector<double> with_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                               std::vector<double> outputs);

/// The outputs of the hysteresis of an actuator that has these outputs. `counts[i]` false: the output of a row is unknown,
/// and its time does not pass. Empty: all count.
std::vector<double> without_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                                  std::vector<double> outputs, const std::vector<bool>& counts = {});

}  // namespace hystcan::identification
