// Statistics of the tracking error for each segment of the reference.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "controller/control/axis.h"

namespace hystcan::controller {

struct ErrorStatistics {
  std::size_t samples = 0;
  double sum_of_squares = 0.0;
  double max_um = 0.0;

  void add(double error_um);
  double rms_um() const;
};

/// Error (reference minus measured) of every tracking cycle, per segment. The smooth transitions between
/// segments, live goals and the first `settle_s` of each segment do not count.
class TrackingStatistics {
 public:
  TrackingStatistics(std::size_t segments, double settle_s)
      : settle_s_(settle_s), segments_(segments), against_ideal_(segments) {}

  void add(const AxisReport& report);
  const std::vector<ErrorStatistics>& segments() const { return segments_; }
  ErrorStatistics total() const;
  /// The error against the reference with sharp corners (Trajectory::Point::ideal_um), per segment. It is that of
  /// segments() where the reference has no turnarounds.
  const std::vector<ErrorStatistics>& against_ideal() const { return against_ideal_; }
  ErrorStatistics total_against_ideal() const;

 private:
  double settle_s_;
  std::vector<ErrorStatistics> segments_;
  std::vector<ErrorStatistics> against_ideal_;
};

/// Result of one axis's run.
struct AxisOutcome {
  std::string name;
  double stroke_um = 0.0;  ///< 100 % of the errors in percent: the ascending reference curve's full height
  AxisState state = AxisState::offline;  ///< at the end
  Fault fault;
  TrackingStatistics statistics;
};
AxisOutcome outcome_of(std::string name, const Axis& axis, TrackingStatistics statistics);

}  // namespace hystcan::controller
