// The reference r(t): a sequence of shapes, joined smoothly, known ahead of time so that delays can be
// previewed; or, from any moment on, a live goal in their place.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "controller/reference/handover.h"
#include "controller/reference/shape.h"
#include "controller/reference/transition.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

struct Segment {
  Shape shape;
  /// Smooth way from wherever the reference is to the shape's first value, as long as this or, where the
  /// limits ask for it, longer.
  double transition_s = 0.1;
};

/// What every transition keeps, whatever the limits of the reference: shapes are exempt.
struct TransitionLimits {
  ReferenceLimits motion{};
  /// Where a motion that is left comes to its stand.
  model::Interval range{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
};

/// r(t), t from 0. Starts at `start_um`; after the last segment it holds, or starts over where `repeat`. From
/// go_to() on it is on its way to a goal, then holds it, until resume(), go_to() or start_from().
///
/// Built off the control thread; all else allocates nothing.
class Trajectory {
 public:
  /// Throws std::invalid_argument where the numbers of a shape do not fit together.
  Trajectory(std::vector<Segment> segments, bool repeat, const ReferenceLimits& limits = {},
             const TransitionLimits& transition_limits = {});

  /// The segments from t = 0 on, from rest.
  void start_from(double start_um);

  /// From `t_s` on the segments again, from the first one on: it brakes to a stand within the limit of
  /// acceleration, and goes on from there for transition_s of the first segment, or as much longer as the
  /// limits ask for. Where the acceleration is unlimited it stands at once: a corner where it moved.
  ///
  /// Until `t_s + previewed_s` the reference is what it was before: it has been looked up that far.
  void resume(double t_s, double previewed_s = 0.0) { continue_from(*this, t_s, previewed_s); }

  /// From `t_s` on these segments, from the first one on, from the motion that `before` has there; as
  /// resume().
  void continue_from(const Trajectory& before, double t_s, double previewed_s = 0.0);

  /// From `t_s` on to `goal_um`, and hold it; as resume(), but where the reference itself has a limit of
  /// acceleration: from the present motion along the shortest transition that keeps the limits. It may swing
  /// beyond the goal then, by a fifth of velocity times duration at most.
  void go_to(double t_s, double goal_um, double previewed_s = 0.0);

  /// Of what is left and entered from now on; transitions from segment to segment stay as they are.
  void keep(const TransitionLimits& limits) { transition_limits_ = limits; }

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
  /// The way into the first pass, a transition or the shape behind it, and how far into it.
  struct Place {
    const Handover* handover = nullptr;
    const Transition* transition = nullptr;
    std::size_t segment = 0;
    double t_s = 0.0;
  };
  Place find(double t_s) const;
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
  double rest_of_pass_s_ = 0.0;  ///< without the way into the first shape
  double end_um_ = 0.0;
  double begin_s_ = 0.0;  ///< of the first pass
  Handover first_entry_;  ///< of the first pass
  bool live_ = false;
  double live_since_s_ = 0.0;
  Handover to_goal_;
};

}  // namespace hystcan::controller
