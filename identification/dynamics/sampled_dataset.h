// A dataset for the fit of a mode: evenly sampled, with a drive that moves, in units of order one.
//
// Cycles may be left out: the times are then whole multiples of a cycle T. The drive of a cycle without a row
// is not known; that of the row before is taken, which is exact where the drive rests. Only cycles with a row
// are fitted.
//
// Until the drive has visited both ends of its range, the response depends on a history that is not in the
// dataset. These rows are not fitted if the drive visits both ends again later. After them the hysteresis of
// the small signal consists of closed loops. It is modelled as a Prandtl-Ishlinskii operator: the drive u,
// and play operators P_i of u with fixed thresholds r_i, where 2 R is the range of the drive. Each play
// enters as its difference w_i from its chord:
//
//   r_i = R/4, R/2, 3R/4
//   w_i = P_i[u] - (1 - r_i / R) u + constant        (zero at both ends of the loop)
//
// The gain from end to end is therefore the coefficient of the drive alone. If the drive has only two levels,
// the w_i are zero and are omitted.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "identification/dataset.h"
#include "identification/quasi_static.h"

namespace hystcan::identification {

struct SampledDataset {
  double cycle_s = 0.0;
  double drive_scale = 1.0;          ///< input units: the largest distance from the drive of the first row
  double output_scale = 1.0;         ///< output units: standard deviation from a straight line
  Eigen::Index first = 0;            ///< the cycle of the dataset where the fit begins
  Eigen::MatrixXd inputs;            ///< of all cycles: (input - input of row 0) / drive_scale, then the w_i
  std::vector<Eigen::Index> cycles;  ///< of the fitted rows: counted from `first`
  Eigen::VectorXd time;              ///< of the fitted rows: 2 from the first cycle to the last, mean 0
  Eigen::VectorXd output;            ///< of the fitted rows: (output - mean) / output_scale

  Eigen::Index rows() const { return time.size(); }
  Eigen::Index cycle_of(Eigen::Index row) const { return cycles[static_cast<std::size_t>(row)]; }
  /// From `first` to the last cycle.
  Eigen::Index length() const { return inputs.rows() - first; }
  double duration_s() const { return static_cast<double>(length() - 1) * cycle_s; }
};

/// Throws std::invalid_argument if there are too few rows, where grid_of() does, or if a column is constant.
/// The fit begins `longest_delay_cycles` after the drive has visited both ends.
SampledDataset sampled(const Dataset& dataset, Eigen::Index longest_delay_cycles);

/// The difference of `values` from a straight line.
Eigen::VectorXd without_line(const Eigen::VectorXd& time, const Eigen::VectorXd& values);

}  // namespace hystcan::identification
