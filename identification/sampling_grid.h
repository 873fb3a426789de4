// The grid of an evenly sampled dataset. Cycles may be left out.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace hystcan::identification {

/// The cycle of each row, counted from the first row.
struct Grid {
  double cycle_s = 0.0;
  std::vector<Eigen::Index> cycles;

  Eigen::Index length() const { return cycles.back() + 1; }
};
/// Throws std::invalid_argument where a row is not whole cycles after the one before, within 10 % of a cycle, or if most
/// cycles have no row.
Grid grid_of(const std::vector<double>& time_s);
/// The column in every cycle; that of a cycle without a row is that of the row before.
Eigen::VectorXd held_on(const Grid& grid, const std::vector<double>& column);

}  // namespace hystcan::identification
