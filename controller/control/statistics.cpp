#include "controller/control/statistics.h"

#include <utility>

namespace hystcan::controller {
namespace {

ErrorStatistics sum_of(const std::vector<ErrorStatistics>& segments) {
  ErrorStatistics sum;
  for (const ErrorStatistics& segment : segments) sum.add(segment);
  return sum;
}

}  // namespace

void TrackingStatistics::add(const AxisReport& report) {
  const Trajectory::Point& point = report.point;
  if (report.state != AxisState::tracking || report.sample_missing || point.in_transition || point.finished ||
      point.live) {
    // A missing sample does not end the evaluation of a step response, because the axis continues to track.
    if (!report.sample_missing) leave_level();
    return;
  }
  make_room(point.segment + 1);  // a new setpoint may have more segments
  add_level(report);
  if (point.shape_time_s < settle_s_) return;
  segments_[point.segment].add(report.reference_um - report.position_um);
  against_ideal_[point.segment].add(point.ideal_um - report.position_um);
}

void TrackingStatistics::make_room(std::size_t segments) {
  if (segments <= segments_.size()) return;
  segments_.resize(segments);
  against_ideal_.resize(segments);
  levels_.resize(segments, {metrics::StepResponse(tolerance_um_), metrics::HoldNoise()});
}

void TrackingStatistics::add_level(const AxisReport& report) {
  const Trajectory::Point& point = report.point;
  if (level_of_ != point.segment) leave_level();
  level_of_ = point.segment;
  LevelStatistics& level = levels_[point.segment];
  level.steps.add(point.shape_time_s, report.reference_um, report.position_um, point.at_rest);
  const double band_um = level.steps.present() ? level.steps.present()->band_um : tolerance_um_;
  const bool counts = point.at_rest && point.shape_time_s >= settle_s_;
  level.hold.add(report.reference_um, report.position_um, band_um, counts);
}

void TrackingStatistics::leave_level() {
  if (!level_of_) return;
  levels_[*level_of_].steps.leave();
  levels_[*level_of_].hold.leave();
  level_of_.reset();
}

double settling_tolerance_um(const AxisConfig& config) {
  return config.in_position ? config.in_position->tolerance_um : 0.0;
}

ErrorStatistics TrackingStatistics::total() const { return sum_of(segments_); }

ErrorStatistics TrackingStatistics::total_against_ideal() const { return sum_of(against_ideal_); }

AxisOutcome outcome_of(std::string name, const Axis& axis, TrackingStatistics statistics) {
  const Learning* learning = axis.closed_loop() == nullptr ? nullptr : axis.closed_loop()->learning();
  std::vector<std::string> kinds;
  for (const Segment& segment : axis.config().setpoint) kinds.push_back(to_string(segment.shape));
  return {.name = std::move(name),
          .stroke_um = model_reach_um(axis.config().law.model, axis.config().gate).span(),
          .state = axis.state(),
          .fault = axis.fault(),
          .statistics = std::move(statistics),
          .segment_kinds = std::move(kinds),
          .learning = learning == nullptr ? std::nullopt : std::optional(learning->report())};
}

}  // namespace hystcan::controller
