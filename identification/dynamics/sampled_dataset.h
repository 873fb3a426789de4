// A dataset as the fit of a mode needs it: sampled evenly, its drive moving, in units of order one.
//
// What the drive does to the material before it has once been at both ends of its range depends on a history
// that the dataset does not hold: these rows are not fitted, where the drive goes to both ends once more
// later. After them the small signal's hysteresis is closed loops, taken as a Prandtl-Ishlinskii operator:
// the drive and play operators P_i of it, with fixed thresholds r_i = R/4, R/2, 3R/4, where 2 R is the
// drive's range. Written as what is left of each beside its chord,
//
//   w_i = P_i[u] - (1 - r_i / R) u + constant        (zero at both ends of the loop)
//
// they leave the gain from end to end to the drive. They are zero, and left out, where the drive has two
// levels only.
#pragma once

#include <Eigen/Core>

#include "identification/dataset.h"

namespace hystcan::identification {

struct SampledDataset {
  double cycle_s = 0.0;
  double drive_scale = 1.0;   ///< input units: the largest move from the first row's drive
  double output_scale = 1.0;  ///< output units: standard deviation about a straight line
  Eigen::Index first = 0;     ///< row of the dataset that the fit begins with
  Eigen::MatrixXd inputs;     ///< of all rows: (input - first row's) / drive_scale, and beside it the w_i
  Eigen::VectorXd time;       ///< of the rows fitted: -1 at the first, 1 at the last
  Eigen::VectorXd output;     ///< of the rows fitted: (output - mean) / output_scale

  Eigen::Index rows() const { return time.size(); }
  double duration_s() const { return static_cast<double>(rows() - 1) * cycle_s; }
};

/// Throws std::invalid_argument where rows are too few, their times uneven beyond 1 %, or a column constant.
/// The fit begins when what came before both ends, `longest_delay_cycles` late, has passed.
SampledDataset sampled(const Dataset& dataset, Eigen::Index longest_delay_cycles);

/// What is left of `values` beside a straight line.
Eigen::VectorXd without_line(const Eigen::VectorXd& time, const Eigen::VectorXd& values);

}  // namespace hystcan::identification
