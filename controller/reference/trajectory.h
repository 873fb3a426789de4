// The reference r(t): a sequence of shapes, joined smoothly. It is known ahead of time, so a preview can
// compensate delays. A live goal can replace the shapes at any time.
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
  /// Duration of the smooth transition to the shape's first value; longer where the limits require it.
  double transition_s = 0.1;
};

/// Limits of every transition, in addition to those of the reference. They do not apply to shapes.
struct TransitionLimits {
  ReferenceLimits motion{};
  /// The braking of an old reference ends within this range.
  model::Interval range{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
};

/// r(t). At t = 0 it starts at `start_um`, at 0 if nothing says where; it stands there before. After the last
/// segment it holds, or begins again where `repeat`.
/// After go_to() it moves to a goal and holds it, until resume(), go_to() or start_from().
///
/// Built outside the control thread; only the constructor allocates.
class Trajectory {
 public:
  /// Throws std::invalid_argument where the numbers of a shape contradict each other.
  Trajectory(std::vector<Segment> segments, bool repeat, const ReferenceLimits& limits = {},
             const TransitionLimits& transition_limits = {});

  /// Follows the segments from t = 0 on, beginning at rest.
  void start_from(double start_um);

  /// Follows the segments as if it had from t = 0 on, beginning at rest at `start_um` at `t_s`. Where it
  /// `goes_on`, as if it had never stopped: a reference that resume() or continue_from() began later keeps
  /// this beginning.
  ///
  ///   r(t) = start + share(t) (segments(t) - start)
  ///
  /// The share rises smoothly from 0 to 1, so that the reference stays between the two. It takes as long as a
  /// transition to the furthest value of the segments, so that the motion that the share adds keeps the
  /// limits of transitions.
  void join(double t_s, double start_um, bool goes_on = false);

  /// Follows the segments again, beginning with the first one. The reference stays as it is from `t_s`, the
  /// time of the last sample, until `t_s + previewed_s`, because the preview has used it up to there. It then
  /// brakes to a stand within the limit of acceleration, and moves to the first segment for its transition_s,
  /// or longer where the limits require it. Where the acceleration is unlimited it stands at once: a moving
  /// reference then has a corner.
  void resume(double t_s, double previewed_s = 0.0) { continue_from(*this, t_s, previewed_s); }

  /// Follows these segments after `before`, in the same way as resume().
  void continue_from(const Trajectory& before, double t_s, double previewed_s = 0.0);

  /// Goes to `goal_um` and holds it, in the same way as resume(). Where the reference itself has a limit of
  /// acceleration, it does not brake first: the transition is the shortest one from the present motion that
  /// keeps the limits. It may overshoot the goal by at most a fifth of velocity times duration.
  void go_to(double t_s, double goal_um, double previewed_s = 0.0);

  /// Sets the limits of later handovers; transitions from segment to segment stay as they are.
  void keep(const TransitionLimits& limits) { transition_limits_ = limits; }

  struct Point {
    double value_um = 0.0;
    std::size_t segment = 0;  ///< index; the number of segments where none is followed
    bool in_transition = false;
    bool finished = false;
    bool live = false;          ///< on the way to, or at, a live goal
    bool at_rest = false;       ///< the value does not change; a jump from level to level is no motion
    double shape_time_s = 0.0;  ///< since the shape's beginning
    /// The value with sharp corners in the place of turnarounds; value_um in a transition.
    double ideal_um = 0.0;
    std::optional<ScanPlace> scan{};  ///< empty where no line of a raster is followed
  };
  Point at(double t_s) const;
  /// The value of at(), which is all that a preview needs.
  double value_um(double t_s) const;
  Motion motion(double t_s) const;

  double length_s() const { return first_entry_.duration_s() + rest_of_pass_s_; }  ///< of the first pass
  /// Of a pass that is repeated: from one beginning of the first shape to the next.
  double pass_s() const;
  /// From the beginning of the first shape to that of this segment's shape.
  double begins_s(std::size_t segment) const;
  const std::vector<Segment>& segments() const { return segments_; }

 private:
  /// The handover into the first pass, a transition or a shape, and the time since its beginning.
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
  static constexpr double shortest_s = 1e-3;  ///< of a transition: less is a step
  double usual_transition_s() const;
  ReferenceLimits limits_of_transitions() const { return tighter(limits_, transition_limits_.motion); }
  static Handover::Lead lead(const Trajectory& before, double t_s, double previewed_s);
  Handover braked(const Trajectory& before, double t_s, double previewed_s, double to_um) const;

  std::vector<Segment> segments_;
  std::vector<Transition> entries_;  ///< into each segment; the first: from the end of the last
  std::vector<double> begins_s_;     ///< of each segment's entry, since the first shape's beginning
  bool repeat_;
  ReferenceLimits limits_;
  TransitionLimits transition_limits_;
  /// The values of all segments.
  model::Interval followed_{std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity()};
  double rest_of_pass_s_ = 0.0;  ///< without the way into the first shape
  double end_um_ = 0.0;
  double begin_s_ = 0.0;  ///< of the first pass
  Handover first_entry_;  ///< of the first pass
  std::optional<Joining> joining_;
  bool live_ = false;
  double live_since_s_ = 0.0;
  Handover to_goal_;
};

}  // namespace hystcan::controller
