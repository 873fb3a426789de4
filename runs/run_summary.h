// Collects the results of each axis of a run, row by row: tracking errors and faults. They are stored in the
// run's `run.json`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "controller/control/axis_report.h"
#include "metrics/statistics.h"
#include "runs/run_info.h"

namespace hystcan::runs {

class RunSummary {
 public:
  static constexpr std::size_t most_faults = 100;  ///< faults stored for each axis; later faults are dropped
  static constexpr std::size_t most_axes = 64;

  explicit RunSummary(std::size_t axes) : axes_(axes) {}

  /// Adds one row of an axis. `error_um` counts only if `state` is tracking.
  void add(std::size_t axis, double time_s, controller::AxisState state, controller::Cause cause,
           double error_um);
  std::uint64_t rows() const { return rows_; }
  /// Stores the results in `info`: the number of rows, the times of the first and the last row, and the
  /// errors and faults of each axis.
  void put_into(RunInfo& info) const;

 private:
  struct Axis {
    std::vector<RunFault> faults;
    metrics::ErrorStatistics error{};
    controller::Cause cause = controller::Cause::none;
  };
  std::vector<Axis> axes_;
  std::uint64_t rows_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0;
};

}  // namespace hystcan::runs
