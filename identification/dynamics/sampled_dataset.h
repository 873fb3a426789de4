// A dataset for the fit of a mode: evenly sampled, with a drive that moves, in units of order one.
//
// Cycles may be missing: the times are then whole multiples of a cycle T. The drive of a cycle without a row
// is unknown; the drive of the previous row replaces it, which is exact if the drive rests. Only cycles with
// a row are fitted.
//
// Until the drive has visited both ends of its range, the response depends on a history that is not in the
// dataset. These rows are not fitted if the drive visits both ends again later. After them the hysteresis of
// the small signal consists of closed loops. It is modelled as a Prandtl-Ishlinskii operator: the drive u,
// and play operators P_i of u with fixed thresholds r_i, where 2 R is the range of the drive. Each play is
// used as its difference w_i from its chord:
//
//   r_i = R/4, R/2, 3R/4
//   w_i = P_i[u] - (1 - r_i / R) u + constant        (zero at both ends of the loop)
//
// The coefficient of the drive is therefore the gain from end to end. If the drive has only two levels, the
// w_i are zero and are omitted.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "identification/dataset.h"
#include "identification/quasi_static.h"

namespace hystcan::identification {

struct SampledDataset {
  double cycle_s = 0.0;
  double drive_scale = 1.0;          ///< input units: largest distance from the drive of the first row
  double output_scale = 1.0;         ///< output units: standard deviation from a straight line
  Eigen::Index first = 0;            ///< the cycle of the dataset in which the fit begins
  Eigen::MatrixXd inputs;            ///< in each cycle: (input - input of row 0) / drive_scale, then the w_i
  std::vector<Eigen::Index> cycles;  ///< cycle of each fitted row, counted from `first`
  Eigen::VectorXd time;              ///< time of each fitted row: range 2, mean 0
  Eigen::VectorXd output;            ///< output of each fitted row: (output - mean) / output_scale

  Eigen::Index rows() const { return time.size(); }
  Eigen::Index cycle_of(Eigen::Index row) const { return cycles[static_cast<std::size_t>(row)]; }
  /// Returns the number of cycles from `first` to the last one.
  Eigen::Index length() const { return inputs.rows() - first; }
  double duration_s() const { return static_cast<double>(length() - 1) * cycle_s; }
};

/// Throws std::invalid_argument if there are too few rows, if grid_of() does, or if a column is constant. The
/// fit begins `longest_delay_cycles` after the drive has visited both ends.
SampledDataset sampled(const Dataset& dataset, Eigen::Index longest_delay_cycles);

/// Returns the difference of `values` from a straight line.
Eigen::VectorXd without_line(const Eigen::VectorXd& time, const Eigen::VectorXd& values);

}  // namespace hystcan::identification
