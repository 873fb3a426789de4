// What stands between the output of the hysteresis and the measured one, row by row: creep
// (model/output_creep.h), then a mode and a delay (model/dynamics.h).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "identification/dataset.h"
#include "model/dynamics.h"
#include "model/output_creep.h"

namespace hystcan::identification {

struct Identified;

/// The outputs of an actuator whose hysteresis has these outputs. It begins settled, or in `start`.
std::vector<double> with_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                               std::vector<double> outputs,
                               const std::optional<model::HeldCreep::State>& start = {});

/// The outputs of the hysteresis of an actuator that has these outputs and begins settled. `counts[i]` false:
/// the output of a row is unknown, and its time does not pass. Empty: all count.
std::vector<double> without_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                                  std::vector<double> outputs, const std::vector<bool>& counts = {});

/// The grid of an evenly sampled dataset, in which cycles may be left out: the cycle of each row, counted
/// from the first row.
struct Grid {
  double cycle_s = 0.0;
  std::vector<Eigen::Index> cycles;

  Eigen::Index length() const { return cycles.back() + 1; }
};
/// Throws std::invalid_argument where a row is not whole cycles after the one before, within 10 % of a cycle,
/// or if most cycles have no row.
Grid grid_of(const std::vector<double>& time_s);
/// The column in every cycle; that of a cycle without a row is that of the row before.
Eigen::VectorXd held_on(const Grid& grid, const std::vector<double>& column);

/// The position of the stage at each row. Rows may be left out: the output of the row before is held. Throws
/// std::invalid_argument where the times are no whole multiples of a cycle.
std::vector<double> respond(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                            const std::vector<double>& quasi_static);

/// The quasi-static change whose response is nearly `change`:
///
///   G = conj(F) / max(|F|^2, 1),    F(f): the frequency response of the dynamics
///
/// G F is 1 wherever the stage answers fully, and goes to zero as |F|^2 where it does not: noise is never
/// amplified.
std::vector<double> before_dynamics(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                                    const std::vector<double>& change);

/// x of each dataset: the output of an identified model without dynamics, and without zero, gain and drift of
/// a dataset.
std::vector<std::vector<double>> quasi_static_outputs(const std::vector<Dataset>& datasets,
                                                      const Identified& identified);
/// The datasets x + G (y - F x) of a stage with dynamics, in the zero, gain and drift of each: what its
/// quasi-static model is fitted to.
std::vector<Dataset> without_dynamics(std::vector<Dataset> datasets, const Identified& identified,
                                      const std::vector<std::vector<double>>& outputs);
std::vector<Dataset> without_dynamics(const std::vector<Dataset>& datasets, const Identified& identified);

}  // namespace hystcan::identification
