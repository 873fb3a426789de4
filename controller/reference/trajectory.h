// The reference r(t): a sequence of shapes, joined smoothly. The reference is known in advance, so the
// feed-forward can evaluate it early and thereby compensate delays. A live setpoint can replace the shapes at
// any time.
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
  /// Duration of the smooth transition to the shape's first value. The transition lasts longer if the limits
  /// require it.
  double transition_s = 0.1;
};

/// Limits of velocity, acceleration and position that apply to transitions, in addition to the limits of the
/// reference. They do not apply to shapes.
struct TransitionLimits {
  ReferenceLimits motion{};
  /// Range of positions in which a moving reference must come to rest if another reference or a live setpoint
  /// replaces it.
  model::Interval range{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
};

/// The reference r(t). Before t = 0 it rests at `start_um` (at 0 if no start is given). At t = 0 it starts
/// from there and follows its segments. After the last segment it holds its last value, or begins again if
/// `repeat`. After go_to() it moves to a goal and holds the goal, until resume(), go_to() or start_from().
///
/// A Trajectory is constructed outside the control thread; only the constructor allocates.
class Trajectory {
 public:
  /// Throws std::invalid_argument if the parameters of a shape contradict each other.
  Trajectory(std::vector<Segment> segments, bool repeat, const ReferenceLimits& limits = {},
             const TransitionLimits& transition_limits = {});

  /// Follows the segments from t = 0 on. The reference starts at rest at `start_um`.
  void start_from(double start_um);

  /// Joins the segments at the time `t_s`: the reference starts at rest at `start_um`, and moves smoothly to
  /// where it would be if its segments had begun at t = 0. With `goes_on`, it moves to where it would be if
  /// it had never stopped: the segments keep a later beginning that resume() or continue_from() has set.
  ///
  ///   r(t) = start + share(t) (segments(t) - start)
  ///
  /// start is `start_um`, and segments(t) is the reference without join(). The share rises smoothly from 0 to
  /// 1, so that r(t) is between start and segments(t). The rise takes as long as a transition to the value of
  /// the segments that is furthest from start. Therefore the motion that the share adds keeps the limits of
  /// transitions.
  void join(double t_s, double start_um, bool goes_on = false);

  /// Ends a live setpoint, or restarts the segments: follows the segments, beginning with the first one. The
  /// reference does not change from `t_s`, the time of the last sample, until `t_s + previewed_s`, because
  /// the feed-forward has already used this part. Then the reference brakes to rest within the limit of
  /// acceleration. Finally it moves to the first segment within its transition_s, or longer if the limits
  /// require it. If the acceleration is unlimited, the reference stops immediately; if it was moving, it has
  /// a corner there.
  void resume(double t_s, double previewed_s = 0.0) { continue_from(*this, t_s, previewed_s); }

  /// Follows the segments of this trajectory, beginning with the first one. The reference continues the
  /// motion of `before`, then brakes and moves to the first segment, in the same way as in resume().
  void continue_from(const Trajectory& before, double t_s, double previewed_s = 0.0);

  /// Moves to `goal_um` and holds this position. The reference continues, brakes and moves in the same way as
  /// in resume(). If the acceleration of the whole reference is limited, and not only that of transitions,
  /// the reference does not brake first: the shortest transition that keeps the limits leads from the present
  /// motion to the goal. It may overshoot the goal by at most a fifth of the product of its initial velocity
  /// and its duration.
  void go_to(double t_s, double goal_um, double previewed_s = 0.0);

  /// Sets the limits of transitions for later changes to another reference or to a live setpoint. The
  /// transitions between the segments of this trajectory are planned already and do not change.
  void keep(const TransitionLimits& limits) { transition_limits_ = limits; }

  struct Point {
    double value_um = 0.0;
    /// Index of the present segment; the number of segments if no segment is followed.
    std::size_t segment = 0;
    bool in_transition = false;
    bool finished = false;
    bool live = false;          ///< true while the reference moves to a live setpoint or rests there
    bool at_rest = false;       ///< the value does not change; a jump between levels does not count as motion
    double shape_time_s = 0.0;  ///< time since the shape's beginning
    /// The value with sharp corners instead of rounded ones (turnarounds). In a transition it equals
    /// value_um.
    double ideal_um = 0.0;
    std::optional<ScanPlace> scan{};  ///< frame, line and pixel of a raster; empty outside its lines
  };
  Point at(double t_s) const;
  /// Returns the same value as at(t_s).value_um, in less time than at() needs.
  double value_um(double t_s) const;
  Motion motion(double t_s) const;

  /// Returns the duration of the first pass through all segments, including the transition from the start.
  double length_s() const { return first_entry_.duration_s() + rest_of_pass_s_; }
  /// Returns the duration of a repeated pass: from one beginning of the first shape to the next.
  double pass_s() const;
  /// Returns the time from the beginning of the first shape to the beginning of this segment's shape.
  double begins_s(std::size_t segment) const;
  const std::vector<Segment>& segments() const { return segments_; }

 private:
  /// The part of the reference at one time, and the time `t_s` since the beginning of this part. The part is
  /// a Handover (from one reference to another) if `handover` is set, a transition into a segment if
  /// `transition` is set, and otherwise the shape of a segment.
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
  static constexpr double shortest_s = 1e-3;  ///< minimum duration of a transition to a live setpoint
  double usual_transition_s() const;
  ReferenceLimits limits_of_transitions() const { return tighter(limits_, transition_limits_.motion); }
  static Handover::Lead lead(const Trajectory& before, double t_s, double previewed_s);
  Handover braked(const Trajectory& before, double t_s, double previewed_s, double to_um) const;

  std::vector<Segment> segments_;
  /// Transition into each segment. The transition into the first segment starts at the end of the last
  /// segment, and is used if the reference repeats.
  std::vector<Transition> entries_;
  /// For each segment: time from the beginning of the first shape to the transition into the segment.
  std::vector<double> begins_s_;
  bool repeat_;
  ReferenceLimits limits_;
  TransitionLimits transition_limits_;
  /// Lowest and highest position of all segments.
  model::Interval followed_{std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity()};
  /// Duration of a pass through all segments, without the transition into the first shape.
  double rest_of_pass_s_ = 0.0;
  double end_um_ = 0.0;
  double begin_s_ = 0.0;  ///< time at which the first pass through the segments begins
  Handover first_entry_;  ///< motion from the start, or from another reference, into the first shape
  std::optional<Joining> joining_;
  bool live_ = false;
  double live_since_s_ = 0.0;
  Handover to_goal_;
};

}  // namespace hystcan::controller
