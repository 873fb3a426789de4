// Between the quasi-static output of a stage and its measured one: a mode and a delay (model/dynamics.h).
#pragma once

#include <vector>

#include "identification/identify.h"
#include "model/dynamics.h"

namespace hystcan::identification {

/// The position of the stage at each row. Rows may be left out: the output of the row before is held. Throws
/// std::invalid_argument where the times are no whole multiples of a cycle (sampling_grid.h).
std::vector<double> respond(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                            const std::vector<double>& quasi_static);

/// The quasi-static change whose response is nearly `change`:
///
///   G = conj(F) / max(|F|^2, 1),    F(f): the frequency response of the dynamics
///
/// G F is 1 wherever the stage answers fully, and goes to zero as |F|^2 where it does not: noise is never amplified.
std::vector<double> before_dynamics(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                                    const std::vector<double>& change);

/// x of each dataset: the output of an identified model without dynamics, and without zero, gain and drift of a dataset.
std::vector<std::vector<double>> quasi_static_outputs(const std::vector<Dataset>& datasets,
                                                      const Identified& identified);
/// The datasets x + G (y - F x) of a stage with dynamics, in the zero, gain and drift of each: what its quasi-static
/// model is fitted to.
std::vector<Dataset> without_dynamics(std::vector<Dataset> datasets, const Identified& identified,
                                      const std::vector<std::vector<double>>& outputs);
std::vector<Dataset> without_dynamics(const std::vector<Dataset>& datasets, const Identified& identified);

}  // namespace hystcan::identification
