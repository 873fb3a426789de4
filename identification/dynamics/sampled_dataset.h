// Prepares a dataset for the fit of a mode. The result is evenly sampled, its drive moves, and its numbers
// are of order one.
//
// Cycles may be missing: the time between two rows is then a multiple of the cycle length T. In a cycle
// without a row, the drive is unknown; it is replaced by the drive of the previous row. This is exact if the
// drive rests. Only cycles with a row are fitted.
//
// Before the drive has visited both ends of its range, the response depends on a history that is not in the
// dataset. The rows before that time are not fitted. But if the drive does not visit both ends again after
// that time, all rows are fitted. In the fitted rows, the hysteresis of the small signal consists of closed
// loops. The loops are modelled by play operators P_i of the drive u (Prandtl-Ishlinskii), with thresholds
// r_i. 2 R is the range of the drive. Each play is used as its difference w_i from a straight line:
//
//   r_i = R/4, R/2, 3R/4
//   w_i = P_i[u] - (1 - r_i / R) u + constant        (zero at both ends of the loop)
//
// The coefficient of the drive in the fit is therefore the gain from end to end of the loop. If the drive has
// only two levels, all w_i are zero and are left out.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "identification/dataset.h"
#include "identification/quasi_static.h"

namespace hystcan::identification {

struct SampledDataset {
  double cycle_s = 0.0;
  double drive_scale = 1.0;   ///< largest distance of the input from the input of row 0, input units
  double output_scale = 1.0;  ///< standard deviation of the output from a straight line, output units
  Eigen::Index first = 0;     ///< cycle in which the fit begins, counted from row 0
  /// Inputs of the mode in each cycle. Column 0 is (input - input of row 0) / drive_scale. The other columns
  /// are the loops of the plays, one column for each play.
  Eigen::MatrixXd inputs;
  std::vector<Eigen::Index> cycles;  ///< cycle of each fitted row, counted from `first`
  Eigen::VectorXd time;    ///< time of each fitted row, scaled so that it covers a range of 2 with the mean 0
  Eigen::VectorXd output;  ///< output of each fitted row: (output - mean) / output_scale

  Eigen::Index rows() const { return time.size(); }
  Eigen::Index cycle_of(Eigen::Index row) const { return cycles[static_cast<std::size_t>(row)]; }
  /// Returns the number of cycles from `first` to the end of the dataset.
  Eigen::Index length() const { return inputs.rows() - first; }
  double duration_s() const { return static_cast<double>(length() - 1) * cycle_s; }
};

/// Prepares the dataset. The fit begins `longest_delay_cycles` + 1 cycles after the drive has visited both
/// ends of its range. If the drive then does not visit both ends again, or if too few rows would remain, the
/// fit begins in the first row. Throws std::invalid_argument if there are too few rows, if the dataset is not
/// evenly sampled (grid_of()), if the input is constant, or if the output is a straight line.
SampledDataset sampled(const Dataset& dataset, Eigen::Index longest_delay_cycles);

/// Returns the values without their best straight line. `time` must have the mean 0.
Eigen::VectorXd without_line(const Eigen::VectorXd& time, const Eigen::VectorXd& values);

}  // namespace hystcan::identification
