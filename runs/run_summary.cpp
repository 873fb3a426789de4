#include "runs/run_summary.h"

#include <cmath>

namespace hystcan::runs {

void RunSummary::add(const Row& row) {
  if (rows_++ == 0) first_s_ = row.time_s;
  last_s_ = row.time_s;
  Axis& axis = axes_[row.axis];
  if (row.state == controller::AxisState::tracking && std::isfinite(row.error_um)) {
    ++axis.summary.tracked_rows;
    axis.squares_um2 += row.error_um * row.error_um;
    axis.summary.max_um = std::fmax(axis.summary.max_um, std::abs(row.error_um));
  }
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
    if (summary.tracked_rows > 0)
      summary.rms_um = std::sqrt(axes_[i].squares_um2 / static_cast<double>(summary.tracked_rows));
    info.axes[i].summary = std::move(summary);
  }
}

}  // namespace hystcan::runs
