// The reference r(t): a sequence of shapes, joined smoothly, known ahead of time so that delays can be
// previewed; or, from any moment on, a live goal in their place.
#pragma once

#include <cstddef>
#include <vector>

#include "controller/reference/shape.h"
#include "controller/reference/transition.h"

namespace hystcan::controller {

struct Segment {
  Shape shape;
  /// Smooth way from wherever the reference is to the shape's first value, as long as this or, where the
  /// limits ask for it, longer.
  double transition_s = 0.1;
};

/// r(t), t from 0. Starts at `start_um`; after the last segment it holds, or starts over where `repeat`. From
/// go_to() on it is on its way to a goal, then holds it, until resume(), go_to() or start_from().
///
/// Built off the control thread; all else allocates nothing.
class Trajectory {
 public:
  /// Throws std::invalid_argument where the numbers of a shape do not fit together.
  Trajectory(std::vector<Segment> segments, bool repeat, const ReferenceLimits& limits = {});

  /// The segments from t = 0 on, from rest.
  void start_from(double start_um);

  /// From `t_s` on to `goal_um` and hold it: from the present motion along the shortest transition that keeps
  /// the limits; it may swing beyond the goal, by a fifth of velocity times duration at most. Where the
  /// acceleration is unlimited it takes transition_s of the first segment, or longer, and begins at rest: a
  /// corner where the reference moved, but nothing beyond where it was and the goal.
  void go_to(double t_s, double goal_um);

  /// From `t_s` on the segments again, from the first one on, in the same way.
  void resume(double t_s);

  /// From `t_s` on these segments, from the first one on, from the motion that `before` has there; in the
  /// same way.
  void continue_from(const Trajectory& before, double t_s) { begin_at(t_s, before.motion(t_s)); }

  struct Point {
    double value_um = 0.0;
    std::size_t segment = 0;  ///< the number of segments where none is followed
    bool in_transition = false;
    bool finished = false;
    bool live = false;          ///< on the way to, or at, a live goal
    bool at_rest = false;       ///< the value does not change; a jump from level to level is no motion
    double shape_time_s = 0.0;  ///< since the shape's beginning
  };
  Point at(double t_s) const;
  /// As at(): all that a preview needs.
  double value_um(double t_s) const;
  Motion motion(double t_s) const;

  double length_s() const { return first_entry_.duration_s() + rest_of_pass_s_; }  ///< of the first pass
  const std::vector<Segment>& segments() const { return segments_; }

 private:
  /// A transition or the shape behind it, and how far into it.
  struct Place {
    const Transition* transition = nullptr;
    std::size_t segment = 0;
    double t_s = 0.0;
  };
  Place find(double t_s) const;
  void begin_at(double t_s, const Motion& from);
  static constexpr double shortest_s = 1e-3;  ///< of a transition: less is a step
  double usual_transition_s() const;
  Transition way(const Motion& from, double to_um, double least_from_rest_s) const;

  std::vector<Segment> segments_;
  std::vector<Transition> entries_;  ///< into each segment; the first: from the end of the last
  std::vector<double> begins_s_;     ///< of each segment's entry, since the first shape's beginning
  bool repeat_;
  ReferenceLimits limits_;
  double rest_of_pass_s_ = 0.0;  ///< without the way into the first shape
  double end_um_ = 0.0;
  double begin_s_ = 0.0;    ///< of the first pass
  Transition first_entry_;  ///< of the first pass
  bool live_ = false;
  double live_since_s_ = 0.0;
  Transition to_goal_;
};

}  // namespace hystcan::controller
