// Computes, row by row, what happens between the output of the hysteresis and the measured output. First
// there is creep (model/output_creep.h), then a second-order mode with a delay (model/dynamics.h). Also
// computes the inverse.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "identification/dataset.h"
#include "model/dynamics.h"
#include "model/output_creep.h"

namespace hystcan::identification {

struct Identified;

/// Adds creep to the outputs of a hysteresis. `start` is the state of the creep at the first row; without
/// `start`, the creep is settled at the first row.
std::vector<double> with_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                               std::vector<double> outputs,
                               const std::optional<model::HeldCreep::State>& start = {});

/// Removes creep from the outputs of an actuator. The creep is settled at the first row. If `counts[i]` is
/// false, the output of row i is unknown, and the creep does not advance in this row. If `counts` is empty,
/// all rows count.
std::vector<double> without_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                                  std::vector<double> outputs, const std::vector<bool>& counts = {});

/// The cycle of each row of an evenly sampled dataset. The cycle numbers begin at 0 in the first row; a cycle
/// may have no row.
struct Grid {
  double cycle_s = 0.0;
  std::vector<Eigen::Index> cycles;

  Eigen::Index length() const { return cycles.back() + 1; }
};
/// Finds the cycle of each row from the times of the rows. Throws std::invalid_argument if the time between
/// two rows is not a whole number of cycles, within 10 % of a cycle, or if more than half of the cycles have
/// no row.
Grid grid_of(const std::vector<double>& time_s);
/// Returns the values of a column for all cycles. A cycle without a row gets the value of the row before it.
Eigen::VectorXd held_on(const Grid& grid, const std::vector<double>& column);

/// Returns the position of the stage at each row. `quasi_static` is the output of the hysteresis, with creep,
/// at each row; in a cycle without a row, it keeps its value. Throws std::invalid_argument if grid_of()
/// throws it.
std::vector<double> respond(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                            const std::vector<double>& quasi_static);

/// Returns the change of the quasi-static output that causes nearly the change `change` of the position. It
/// is an approximate inverse G of the frequency response F of the dynamics:
///
///   G = conj(F) / max(|F|^2, 1)
///
/// G F is 1 at frequencies where the stage responds fully (|F| >= 1). At other frequencies it is |F|^2, so
/// that noise is never amplified.
std::vector<double> before_dynamics(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                                    const std::vector<double>& change);

/// Returns the output x that the model has without dynamics, for each row of each dataset. Offset, gain and
/// drift of the dataset are not included.
std::vector<std::vector<double>> quasi_static_outputs(const std::vector<Dataset>& datasets,
                                                      const Identified& identified);
/// Returns the datasets that a stage would have without its dynamics. With the measured output y, the
/// quasi-static output x of the model, its dynamics F and their approximate inverse G (before_dynamics()),
/// the new output is
///
///   x + G (y - F x)
///
/// Each dataset keeps its offset, gain and drift. The quasi-static model of the stage is fitted to the
/// result. `outputs`: x of each dataset.
std::vector<Dataset> without_dynamics(std::vector<Dataset> datasets, const Identified& identified,
                                      const std::vector<std::vector<double>>& outputs);
std::vector<Dataset> without_dynamics(const std::vector<Dataset>& datasets, const Identified& identified);

}  // namespace hystcan::identification
