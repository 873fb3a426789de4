// The reference r(t): a sequence of shapes, joined smoothly. It is known ahead of time, so a preview can
// compensate delays. A live goal can replace the shapes at any time.
#pragma once

#include <cstddef>
#include <vector>

#include "controller/reference/shape.h"
#include "controller/reference/transition.h"

namespace hystcan::controller {

struct Segment {
  Shape shape;
  /// Duration of the smooth transition to the shape's first value; longer where the limits require it.
  double transition_s = 0.1;
};

/// r(t), t >= 0. It starts at `start_um`; after the last segment it holds, or begins again where `repeat`.
/// After go_to() it moves to a goal and holds it, until resume(), go_to() or start_from().
///
/// Built outside the control thread; only the constructor allocates.
class Trajectory {
 public:
  /// Throws std::invalid_argument where the numbers of a shape contradict each other.
  Trajectory(std::vector<Segment> segments, bool repeat, const ReferenceLimits& limits = {});

  /// Follows the segments from t = 0 on, beginning at rest.
  void start_from(double start_um);

  /// Goes to `goal_um` from `t_s` on and holds it. The transition begins with the present motion and is the
  /// shortest one that keeps the limits; it may overshoot the goal by at most a fifth of velocity times
  /// duration. Where the acceleration is unlimited, the transition takes transition_s of the first segment
  /// or longer and begins at rest: a moving reference then has a corner, but no overshoot.
  void go_to(double t_s, double goal_um);

  /// Follows the segments again from `t_s` on, beginning with the first one, with the same kind of
  /// transition.
  void resume(double t_s);

  /// Follows these segments from `t_s` on, beginning with the first one, from the motion of `before` at
  /// `t_s`, with the same kind of transition.
  void continue_from(const Trajectory& before, double t_s) { begin_at(t_s, before.motion(t_s)); }

  struct Point {
    double value_um = 0.0;
    std::size_t segment = 0;  ///< index; the number of segments where none is followed
    bool in_transition = false;
    bool finished = false;
    bool live = false;          ///< moves to a live goal or holds it
    bool at_rest = false;       ///< the value is constant; a jump between levels does not count as motion
    double shape_time_s = 0.0;  ///< since the shape's beginning
  };
  Point at(double t_s) const;
  /// As at(), the value alone: for a preview.
  double value_um(double t_s) const;
  Motion motion(double t_s) const;

  double length_s() const { return first_entry_.duration_s() + rest_of_pass_s_; }  ///< of the first pass
  const std::vector<Segment>& segments() const { return segments_; }

 private:
  /// A transition or the shape after it, and the time since its beginning.
  struct Place {
    const Transition* transition = nullptr;
    std::size_t segment = 0;
    double t_s = 0.0;
  };
  Place find(double t_s) const;
  void begin_at(double t_s, const Motion& from);
  static constexpr double shortest_s = 1e-3;  ///< of a transition; a shorter one is a step
  double usual_transition_s() const;
  Transition transition_from(const Motion& from, double to_um, double least_from_rest_s) const;

  std::vector<Segment> segments_;
  std::vector<Transition> entries_;  ///< into each segment; the first one starts at the end of the last
  std::vector<double> begins_s_;     ///< of each segment's entry, since the first shape's beginning
  bool repeat_;
  ReferenceLimits limits_;
  double rest_of_pass_s_ = 0.0;  ///< without the transition into the first shape
  double end_um_ = 0.0;
  double begin_s_ = 0.0;    ///< of the first pass
  Transition first_entry_;  ///< of the first pass
  bool live_ = false;
  double live_since_s_ = 0.0;
  Transition to_goal_;
};

}  // namespace hystcan::controller
