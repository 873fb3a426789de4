// Counts what the axes of a run did, row by row.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "controller/control/axis.h"
#include "metrics/statistics.h"
#include "runs/run_info.h"

namespace hystcan::runs {

class RunSummary {
 public:
  static constexpr std::size_t most_faults = 100;  ///< of an axis; later ones are left out
  static constexpr std::size_t most_axes = 64;

  explicit RunSummary(std::size_t axes) : axes_(axes) {}

  struct Row {
    std::size_t axis = 0;
    double time_s = 0.0;
    controller::AxisState state = controller::AxisState::offline;
    controller::Cause cause = controller::Cause::none;
    double error_um = 0.0;  ///< counts while the axis tracks
  };
  void add(const Row& row);
  std::uint64_t rows() const { return rows_; }
  /// Writes rows, times and the summaries of the axes.
  void put_into(RunInfo& info) const;

 private:
  struct Axis {
    AxisSummary summary;
    metrics::ErrorStatistics error{};
    controller::Cause cause = controller::Cause::none;
  };
  std::vector<Axis> axes_;
  std::uint64_t rows_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0;
};

}  // namespace hystcan::runs
