#include "runs/run_summary.h"

#include <cmath>

namespace hystcan::runs {

void RunSummary::add(const Row& row) {
  if (rows_++ == 0) first_s_ = row.time_s;
  last_s_ = row.time_s;
  Axis& axis = axes_[row.axis];
  if (row.state == controller::AxisState::tracking && std::isfinite(row.error_um))
    axis.error.add(row.error_um);
  if (row.cause != axis.cause && row.cause != controller::Cause::none &&
      axis.summary.faults.size() < most_faults)
    axis.summary.faults.push_back({std::string(to_string(row.cause)), row.time_s});
  axis.cause = row.cause;
}

void RunSummary::put_into(RunInfo& info) const {
  info.rows = rows_;
  info.first_s = first_s_;
  info.last_s = last_s_;
  for (std::size_t i = 0; i < info.axes.size(); ++i) {
    AxisSummary summary = axes_[i].summary;
    if (const metrics::ErrorStatistics& error = axes_[i].error; error.samples > 0) {
      summary.tracked_rows = error.samples;
      summary.rms_um = error.rms_um();
      summary.max_um = error.max_um;
    }
    info.axes[i].summary = std::move(summary);
  }
}

}  // namespace hystcan::runs
