#include "controller/control/statistics.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::controller {
namespace {

ErrorStatistics sum_of(const std::vector<ErrorStatistics>& segments) {
  ErrorStatistics sum;
  for (const ErrorStatistics& segment : segments) {
    sum.samples += segment.samples;
    sum.sum_of_squares += segment.sum_of_squares;
    sum.max_um = std::max(sum.max_um, segment.max_um);
  }
  return sum;
}

}  // namespace

void ErrorStatistics::add(double error_um) {
  ++samples;
  sum_of_squares += error_um * error_um;
  max_um = std::max(max_um, std::abs(error_um));
}

double ErrorStatistics::rms_um() const {
  return samples == 0 ? 0.0 : std::sqrt(sum_of_squares / static_cast<double>(samples));
}

void TrackingStatistics::add(const AxisReport& report) {
  const Trajectory::Point& point = report.point;
  if (report.state != AxisState::tracking || report.sample_missing || point.in_transition || point.finished ||
      point.live)
    return;
  if (point.shape_time_s < settle_s_) return;
  // A new setpoint may have more segments.
  if (point.segment >= segments_.size()) {
    segments_.resize(point.segment + 1);
    against_ideal_.resize(point.segment + 1);
  }
  segments_[point.segment].add(report.reference_um - report.position_um);
  against_ideal_[point.segment].add(point.ideal_um - report.position_um);
}

ErrorStatistics TrackingStatistics::total() const { return sum_of(segments_); }

ErrorStatistics TrackingStatistics::total_against_ideal() const { return sum_of(against_ideal_); }

AxisOutcome outcome_of(std::string name, const Axis& axis, TrackingStatistics statistics) {
  const model::ReferenceCurve& ascending = axis.config().law.model.ascending;
  const model::Interval& range = ascending.domain();
  return {.name = std::move(name),
          .stroke_um = ascending.value(range.hi) - ascending.value(range.lo),
          .state = axis.state(),
          .fault = axis.fault(),
          .statistics = std::move(statistics)};
}

}  // namespace hystcan::controller
