// Statistics of the tracking error for each segment of the reference.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "controller/control/axis.h"
#include "metrics/statistics.h"
#include "metrics/step_response.h"

namespace hystcan::controller {

using metrics::ErrorStatistics;

/// How the stage arrived at the levels of one segment, and how quietly it stayed there.
struct LevelStatistics {
  metrics::StepResponse steps;
  metrics::HoldNoise hold;
};

/// in_position.tolerance_um; 0 where it is not configured.
double settling_tolerance_um(const AxisConfig& config);

/// Error (reference minus measured) of every tracking cycle, per segment. The smooth transitions between
/// segments, live goals and the first `settle_s` of each segment do not count. Steps count from their
/// beginning.
class TrackingStatistics {
 public:
  TrackingStatistics(const AxisConfig& config, double settle_s)
      : TrackingStatistics(config.setpoint.size(), settle_s, settling_tolerance_um(config)) {}
  /// `tolerance_um`: of StepResponse.
  TrackingStatistics(std::size_t segments, double settle_s, double tolerance_um = 0.0)
      : settle_s_(settle_s), tolerance_um_(tolerance_um) {
    make_room(segments);
  }

  void add(const AxisReport& report);
  const std::vector<ErrorStatistics>& segments() const { return segments_; }
  const std::vector<LevelStatistics>& levels() const { return levels_; }
  double tolerance_um() const { return tolerance_um_; }
  ErrorStatistics total() const;
  /// The error against the reference with sharp corners (Trajectory::Point::ideal_um), per segment. It is
  /// that of segments() where the reference has no turnarounds.
  const std::vector<ErrorStatistics>& against_ideal() const { return against_ideal_; }
  ErrorStatistics total_against_ideal() const;

 private:
  void make_room(std::size_t segments);
  void add_level(const AxisReport& report);
  void leave_level();

  double settle_s_;
  double tolerance_um_;
  std::vector<ErrorStatistics> segments_;
  std::vector<ErrorStatistics> against_ideal_;
  std::vector<LevelStatistics> levels_;
  std::optional<std::size_t> level_of_;  ///< the segment whose levels are followed now
};

/// Result of one axis's run.
struct AxisOutcome {
  std::string name;
  double stroke_um = 0.0;  ///< 100 % of the errors in percent: the ascending reference curve's full height
  AxisState state = AxisState::offline;  ///< at the end
  Fault fault;
  TrackingStatistics statistics;
  std::vector<std::string> segment_kinds;
  std::optional<Learning::Report> learning{};  ///< empty: it learns nothing
};
AxisOutcome outcome_of(std::string name, const Axis& axis, TrackingStatistics statistics);

}  // namespace hystcan::controller
