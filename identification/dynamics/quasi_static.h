// Between the quasi-static output of a stage and its measured one: a mode and a delay (model/dynamics.h).
#pragma once

#include <vector>

#include "model/dynamics.h"

namespace hystcan::identification {

/// The position of the stage at each row. Rows may be left out: the output of the row before is held. Throws
/// std::invalid_argument where the times are no whole multiples of a cycle (sampled_dataset.h).
std::vector<double> respond(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                            const std::vector<double>& quasi_static);

/// The quasi-static change whose response is nearly `change`:
///
///   G = conj(F) / max(|F|^2, 1),    F(f): the frequency response of the dynamics
///
/// G F is 1 wherever the stage answers fully, and goes to zero as |F|^2 where it does not: noise is never amplified.
std::vector<double> before_dynamics(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                                    const std::vector<double>& change);

}  // namespace hystcan::identification
