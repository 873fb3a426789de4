// The links between the output of the hysteresis and the measured output, row by row: creep
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

/// Adds creep to the outputs of a hysteresis. At the first row the creep is settled, or in the state `start`.
std::vector<double> with_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                               std::vector<double> outputs,
                               const std::optional<model::HeldCreep::State>& start = {});

/// Removes creep, which is settled at the first row, from the outputs of an actuator. If `counts[i]` is
/// false, the output of row i is unknown, and the creep does not advance in this row. If `counts` is empty,
/// all rows count.
std::vector<double> without_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                                  std::vector<double> outputs, const std::vector<bool>& counts = {});

/// The grid of an evenly sampled dataset, in which cycles may be missing: the cycle of each row, counted from
/// the first row.
struct Grid {
  double cycle_s = 0.0;
  std::vector<Eigen::Index> cycles;

  Eigen::Index length() const { return cycles.back() + 1; }
};
/// Throws std::invalid_argument if the distance of two rows is not a whole number of cycles, within 10 % of a
/// cycle, or if most cycles have no row.
Grid grid_of(const std::vector<double>& time_s);
/// Returns the column in every cycle; a cycle without a row has the value of the previous row.
Eigen::VectorXd held_on(const Grid& grid, const std::vector<double>& column);

/// Returns the position of the stage at each row. Rows may be missing: the output of the previous row is
/// held. Throws std::invalid_argument if the times are not whole multiples of a cycle.
std::vector<double> respond(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                            const std::vector<double>& quasi_static);

/// Returns the quasi-static change whose response is nearly `change`:
///
///   G = conj(F) / max(|F|^2, 1),    F(f): the frequency response of the dynamics
///
/// G F is 1 where the stage responds fully, and falls to zero as |F|^2 where it does not: noise is never
/// amplified.
std::vector<double> before_dynamics(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                                    const std::vector<double>& change);

/// Returns x of each dataset: the output of an identified model without dynamics, and without zero, gain and
/// drift of the dataset.
std::vector<std::vector<double>> quasi_static_outputs(const std::vector<Dataset>& datasets,
                                                      const Identified& identified);
/// Returns the datasets x + G (y - F x) of a stage with dynamics, each with its zero, gain and drift. The
/// quasi-static model of the stage is fitted to these datasets.
std::vector<Dataset> without_dynamics(std::vector<Dataset> datasets, const Identified& identified,
                                      const std::vector<std::vector<double>>& outputs);
std::vector<Dataset> without_dynamics(const std::vector<Dataset>& datasets, const Identified& identified);

}  // namespace hystcan::identification
