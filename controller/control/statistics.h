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

/// The step responses to the levels of one segment, and the noise while the axis holds these levels.
struct LevelStatistics {
  metrics::StepResponse steps;
  metrics::HoldNoise hold;
};

/// Returns in_position.tolerance_um of the axis; 0 if the configuration has none.
double settling_tolerance_um(const AxisConfig& config);

/// Statistics of the error (reference minus measured) of every tracking cycle, for each segment. They exclude
/// the smooth transitions between segments, live setpoints, and the first `settle_s` of each segment. Step
/// responses are evaluated from the beginning of each step.
class TrackingStatistics {
 public:
  TrackingStatistics(const AxisConfig& config, double settle_s)
      : TrackingStatistics(config.setpoint.size(), settle_s, settling_tolerance_um(config)) {}
  /// `settle_s`: time at the beginning of each segment whose errors are left out. `tolerance_um`: error
  /// within which a step response counts as settled.
  TrackingStatistics(std::size_t segments, double settle_s, double tolerance_um = 0.0)
      : settle_s_(settle_s), tolerance_um_(tolerance_um) {
    make_room(segments);
  }

  void add(const AxisReport& report);
  const std::vector<ErrorStatistics>& segments() const { return segments_; }
  const std::vector<LevelStatistics>& levels() const { return levels_; }
  double tolerance_um() const { return tolerance_um_; }
  ErrorStatistics total() const;
  /// Returns the statistics of the error against the reference with sharp corners
  /// (Trajectory::Point::ideal_um), for each segment. They equal segments() if the reference has no
  /// turnarounds.
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
  std::optional<std::size_t> level_of_;  ///< segment whose step responses are evaluated now
};

/// The result of a run of one axis.
struct AxisOutcome {
  std::string name;
  /// Distance between the positions that the model reaches at the two ends of the drive's range. Errors in
  /// percent are relative to it.
  double stroke_um = 0.0;
  AxisState state = AxisState::offline;  ///< state at the end of the run
  Fault fault;
  TrackingStatistics statistics;
  std::vector<std::string> segment_kinds;
  std::optional<Learning::Report> learning{};  ///< empty: no learning
};
AxisOutcome outcome_of(std::string name, const Axis& axis, TrackingStatistics statistics);

}  // namespace hystcan::controller
