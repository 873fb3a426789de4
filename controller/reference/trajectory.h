// The reference r(t): a sequence of shapes, joined smoothly. It is known in advance, so a preview can
// compensate delays. A live setpoint can replace the shapes at any time.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "controller/reference/shape.h"
#include "controller/reference/transition.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

struct Segment {
  Shape shape;
  /// Duration of the smooth transition to the shape's first value; longer if the limits require it.
  double transition_s = 0.1;
};

/// Limits of every transition, in addition to those of the reference. They do not apply to shapes.
struct TransitionLimits {
  ReferenceLimits motion{};
  /// Range in which a reference that is replaced while it moves must come to rest.
  model::Interval range{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
};

/// r(t). It rests at `start_um` before t = 0 (at 0 if no start is given) and starts from there at t = 0.
/// After the last segment it holds its value, or begins again if `repeat`. After go_to() it moves to a goal
/// and holds it, until resume(), go_to() or start_from().
///
/// Constructed outside the control thread; only the constructor allocates.
class Trajectory {
 public:
  /// Throws std::invalid_argument if the parameters of a shape contradict each other.
  Trajectory(std::vector<Segment> segments, bool repeat, const ReferenceLimits& limits = {},
             const TransitionLimits& transition_limits = {});

  /// Follows the segments from t = 0 on, starting at rest.
  void start_from(double start_um);

  /// Starts at `t_s`, at rest at `start_um`, and moves smoothly to where the segments would be if they had
  /// begun at t = 0. With `goes_on`: to where they would be if the reference had never stopped, so a later
  /// beginning that resume() or continue_from() had set is kept.
  ///
  ///   r(t) = start + share(t) (segments(t) - start)
  ///
  /// The share rises smoothly from 0 to 1, so that r(t) is between the two. The rise takes as long as a
  /// transition to the furthest value of the segments, so that the motion added by the share keeps the limits
  /// of transitions.
  void join(double t_s, double start_um, bool goes_on = false);

  /// Follows the segments again, beginning with the first one. The reference does not change from `t_s`, the
  /// time of the last sample, until `t_s + previewed_s`, because the preview has used this part. Then it
  /// brakes to rest within the limit of acceleration, and moves to the first segment for its transition_s, or
  /// longer if the limits require it. If the acceleration is unlimited, it stops immediately: a moving
  /// reference then has a corner.
  void resume(double t_s, double previewed_s = 0.0) { continue_from(*this, t_s, previewed_s); }

  /// Follows the segments of this trajectory after the motion of `before`, in the same way as resume().
  void continue_from(const Trajectory& before, double t_s, double previewed_s = 0.0);

  /// Moves to `goal_um` and holds it, in the same way as resume(). If the reference itself has a limit of
  /// acceleration, there is no braking first: the transition is the shortest one from the present motion that
  /// keeps the limits. It may overshoot the goal by at most a fifth of velocity times duration.
  void go_to(double t_s, double goal_um, double previewed_s = 0.0);

  /// Sets the limits for later changes to another reference or live setpoint. The transitions between the
  /// segments of this trajectory are planned already and do not change.
  void keep(const TransitionLimits& limits) { transition_limits_ = limits; }

  struct Point {
    double value_um = 0.0;
    std::size_t segment = 0;  ///< index; the number of segments if none is followed
    bool in_transition = false;
    bool finished = false;
    bool live = false;          ///< moving to a live setpoint, or at it
    bool at_rest = false;       ///< the value does not change; a jump between levels does not count as motion
    double shape_time_s = 0.0;  ///< time since the shape's beginning
    /// The value with sharp corners instead of turnarounds; value_um in a transition.
    double ideal_um = 0.0;
    std::optional<ScanPlace> scan{};  ///< empty outside the lines of a raster
  };
  Point at(double t_s) const;
  /// Returns only the value of at(), for a preview.
  double value_um(double t_s) const;
  Motion motion(double t_s) const;

  /// Duration of the first pass.
  double length_s() const { return first_entry_.duration_s() + rest_of_pass_s_; }
  /// Returns the duration of a repeated pass: from one beginning of the first shape to the next.
  double pass_s() const;
  /// Returns the time from the beginning of the first shape to the beginning of this segment's shape.
  double begins_s(std::size_t segment) const;
  const std::vector<Segment>& segments() const { return segments_; }

 private:
  /// The part of the reference at one time, and the time since the beginning of this part. The part is a
  /// Handover (from one reference to another), a transition into a segment, or else the shape of a segment.
  struct Place {
    const Handover* handover = nullptr;
    const Transition* transition = nullptr;
    std::size_t segment = 0;
    double t_s = 0.0;
  };
  struct Joining {
    Transition share;
    double since_s = 0.0;
    double from_um = 0.0;
  };
  Place find(double t_s) const;
  Point point_of_segments(double t_s) const;
  double segments_um(double t_s) const;
  Motion motion_of_segments(double t_s) const;
  bool is_joining(double t_s) const {
    return joining_ && t_s - joining_->since_s < joining_->share.duration_s();
  }
  static constexpr double shortest_s = 1e-3;  ///< shortest transition; a shorter one is a step
  double usual_transition_s() const;
  ReferenceLimits limits_of_transitions() const { return tighter(limits_, transition_limits_.motion); }
  static Handover::Lead lead(const Trajectory& before, double t_s, double previewed_s);
  Handover braked(const Trajectory& before, double t_s, double previewed_s, double to_um) const;

  std::vector<Segment> segments_;
  /// Transition into each segment; the first one starts at the end of the last segment.
  std::vector<Transition> entries_;
  std::vector<double> begins_s_;  ///< beginning of each transition, since the first shape's beginning
  bool repeat_;
  ReferenceLimits limits_;
  TransitionLimits transition_limits_;
  /// The range of all segments.
  model::Interval followed_{std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity()};
  double rest_of_pass_s_ = 0.0;  ///< duration of a pass without the transition into the first shape
  double end_um_ = 0.0;
  double begin_s_ = 0.0;  ///< beginning of the first pass
  Handover first_entry_;  ///< from the start, or from another reference, into the first shape
  std::optional<Joining> joining_;
  bool live_ = false;
  double live_since_s_ = 0.0;
  Handover to_goal_;
};

}  // namespace hystcan::controller
