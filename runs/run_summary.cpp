#include "runs/run_summary.h"

#include <cmath>

namespace hystcan::runs {

void RunSummary::add(std::size_t index, double time_s, controller::AxisState state, controller::Cause cause,
                     double error_um) {
  if (rows_++ == 0) first_s_ = time_s;
  last_s_ = time_s;
  Axis& axis = axes_[index];
  if (state == controller::AxisState::tracking && std::isfinite(error_um)) axis.error.add(error_um);
  if (cause != axis.cause && cause != controller::Cause::none && axis.faults.size() < most_faults)
    axis.faults.push_back({std::string(to_string(cause)), time_s});
  axis.cause = cause;
}

void RunSummary::put_into(RunInfo& info) const {
  info.rows = rows_;
  info.first_s = first_s_;
  info.last_s = last_s_;
  for (std::size_t i = 0; i < info.axes.size(); ++i) {
    RunAxis& axis = info.axes[i];
    axis.faults = axes_[i].faults;
    const metrics::ErrorStatistics& error = axes_[i].error;
    if (error.samples == 0) continue;
    axis.tracked_rows = error.samples;
    axis.rms_um = error.rms_um();
    axis.max_um = error.max_um;
  }
}

}  // namespace hystcan::runs
