#include "controller/reference/trajectory.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "controller/reference/shape.h"

namespace hystcan::controller {
namespace {

/// Tolerance of a time: a cycle this close before the beginning of a shape or transition belongs to it. The
/// times of cycles are sums and differences, which are rounded.
constexpr double time_rounding_s = 1e-9;

}  // namespace

Trajectory::Trajectory(std::vector<Segment> segments, bool repeat, const ReferenceLimits& limits,
                       const TransitionLimits& transition_limits)
    : segments_(std::move(segments)),
      repeat_(repeat),
      limits_(limits),
      transition_limits_(transition_limits) {
  for (Segment& segment : segments_) {
    segment.shape = prepared(std::move(segment.shape));
    const MotionBounds bounds = motion_bounds(segment.shape);
    followed_ = {std::min(followed_.lo, bounds.lowest_um), std::max(followed_.hi, bounds.highest_um)};
  }
  if (!segments_.empty())
    end_um_ = controller::value_um(segments_.back().shape, duration_s(segments_.back().shape));
  double from_um = end_um_;
  for (const auto& [shape, transition_s] : segments_) {
    const bool first = entries_.empty();
    const double first_um = controller::value_um(shape, 0.0);
    begins_s_.push_back(rest_of_pass_s_);
    entries_.push_back(
        Transition::within(limits_of_transitions(), {.value_um = from_um}, first_um, transition_s));
    rest_of_pass_s_ += duration_s(shape) + (first ? 0.0 : entries_.back().duration_s());
    from_um = controller::value_um(shape, duration_s(shape));
  }
  start_from(0.0);
}

void Trajectory::start_from(double start_um) {
  begin_s_ = 0.0;
  live_ = false;
  joining_.reset();
  if (segments_.empty())
    end_um_ = start_um;
  else
    first_entry_ = Handover(Transition::within(limits_of_transitions(), {.value_um = start_um},
                                               controller::value_um(segments_.front().shape, 0.0),
                                               usual_transition_s()));
}

double Trajectory::pass_s() const {
  return segments_.empty() ? 0.0 : rest_of_pass_s_ + entries_.front().duration_s();
}

double Trajectory::begins_s(std::size_t segment) const {
  return begins_s_[segment] + (segment == 0 ? 0.0 : entries_[segment].duration_s());
}

void Trajectory::join(double t_s, double start_um, bool goes_on) {
  live_ = false;
  if (!goes_on || segments_.empty()) start_from(start_um);
  if (t_s <= 0.0 || segments_.empty()) return;
  const double furthest_um = std::max(followed_.hi - start_um, start_um - followed_.lo);
  const Transition furthest =
      Transition::within(limits_of_transitions(), {}, furthest_um, usual_transition_s());
  joining_ = {.share = Transition({}, 1.0, furthest.duration_s()), .since_s = t_s, .from_um = start_um};
}

void Trajectory::continue_from(const Trajectory& before, double t_s, double previewed_s) {
  if (segments_.empty())
    end_um_ = before.value_um(t_s + previewed_s);
  else
    first_entry_ = braked(before, t_s, previewed_s, controller::value_um(segments_.front().shape, 0.0));
  begin_s_ = t_s;
  live_ = false;
  joining_.reset();
}

void Trajectory::go_to(double t_s, double goal_um, double previewed_s) {
  const bool at_limits = std::isfinite(limits_.acceleration_um_per_s2);
  to_goal_ = at_limits ? Handover(lead(*this, t_s, previewed_s), previewed_s, {},
                                  Transition::within(limits_of_transitions(), motion(t_s + previewed_s),
                                                     goal_um, shortest_s))
                       : braked(*this, t_s, previewed_s, goal_um);
  live_since_s_ = t_s;
  live_ = true;
}

double Trajectory::usual_transition_s() const {
  return segments_.empty() ? Segment{}.transition_s : segments_.front().transition_s;
}

Handover::Lead Trajectory::lead(const Trajectory& before, double t_s, double previewed_s) {
  Handover::Lead lead{};
  if (previewed_s > 0.0)
    for (std::size_t i = 0; i < lead.size(); ++i)
      lead[i] = before.value_um(t_s + previewed_s * static_cast<double>(i) / Handover::lead_intervals);
  return lead;
}

Handover Trajectory::braked(const Trajectory& before, double t_s, double previewed_s, double to_um) const {
  const ReferenceLimits limits = limits_of_transitions();
  const Transition braking =
      Transition::to_stand(limits, before.motion(t_s + previewed_s), transition_limits_.range);
  return {lead(before, t_s, previewed_s), previewed_s, braking,
          Transition::within(limits, {.value_um = braking.end_um()}, to_um, usual_transition_s())};
}

/// Returns the part of the reference at `t_s`. After the end of the last segment there is no such part:
/// Place::segment is then the number of segments.
Trajectory::Place Trajectory::find(double t_s) const {
  if (segments_.empty()) return {};
  t_s -= begin_s_;
  if (t_s < first_entry_.duration_s() - time_rounding_s)
    return {.handover = &first_entry_, .segment = 0, .t_s = t_s};
  t_s -= first_entry_.duration_s();  // now the time since the first shape's beginning
  if (t_s >= rest_of_pass_s_ - time_rounding_s) {
    if (!repeat_) return {.segment = segments_.size()};
    const Transition& entry = entries_.front();
    t_s = std::fmod(t_s - rest_of_pass_s_ + time_rounding_s, rest_of_pass_s_ + entry.duration_s()) -
          time_rounding_s;
    if (t_s < entry.duration_s() - time_rounding_s)
      return {.transition = &entry, .segment = 0, .t_s = std::max(t_s, 0.0)};
    t_s -= entry.duration_s();
  }
  const auto next = std::upper_bound(begins_s_.begin() + 1, begins_s_.end(), t_s + time_rounding_s);
  const auto i = static_cast<std::size_t>(next - begins_s_.begin() - 1);
  t_s -= begins_s_[i];
  if (i == 0) return {.segment = 0, .t_s = std::max(t_s, 0.0)};
  const Transition& entry = entries_[i];
  if (t_s < entry.duration_s() - time_rounding_s)
    return {.transition = &entry, .segment = i, .t_s = std::max(t_s, 0.0)};
  return {.segment = i, .t_s = std::max(t_s - entry.duration_s(), 0.0)};
}

Trajectory::Point Trajectory::at(double t_s) const {
  if (live_) {
    const double on_way_s = t_s - live_since_s_;
    const bool arrived = on_way_s >= to_goal_.duration_s();
    const double value_um = to_goal_.value_um(on_way_s);
    return {.value_um = value_um,
            .segment = segments_.size(),
            .in_transition = !arrived,
            .live = true,
            .at_rest = arrived,
            .shape_time_s = arrived ? on_way_s - to_goal_.duration_s() : 0.0,
            .ideal_um = value_um};
  }
  Point point = point_of_segments(t_s);
  if (!is_joining(t_s)) return point;
  point.value_um = point.ideal_um = value_um(t_s);
  point.in_transition = true;
  point.at_rest = false;
  point.scan.reset();
  return point;
}

Trajectory::Point Trajectory::point_of_segments(double t_s) const {
  const Place place = find(t_s);
  Point point{.segment = place.segment};
  if (place.handover != nullptr) {
    point.value_um = place.handover->value_um(place.t_s);
    point.in_transition = true;
  } else if (place.transition != nullptr) {
    point.value_um = place.transition->value_um(place.t_s);
    point.in_transition = true;
  } else if (place.segment == segments_.size()) {
    point.value_um = end_um_;
    point.finished = point.at_rest = true;
  } else {
    const Shape& shape = segments_[place.segment].shape;
    point.value_um = controller::value_um(shape, place.t_s);
    point.at_rest = rests(shape, place.t_s);
    point.shape_time_s = place.t_s;
    point.ideal_um = has_turnarounds(shape) ? controller::ideal_um(shape, place.t_s) : point.value_um;
    point.scan = place_in_scan(shape, place.t_s);
    return point;
  }
  point.ideal_um = point.value_um;
  return point;
}

double Trajectory::value_um(double t_s) const {
  if (live_) return to_goal_.value_um(t_s - live_since_s_);
  const double followed_um = segments_um(t_s);
  if (!is_joining(t_s)) return followed_um;
  const auto& [share, since_s, from_um] = *joining_;
  return from_um + share.value_um(t_s - since_s) * (followed_um - from_um);
}

double Trajectory::segments_um(double t_s) const {
  const Place place = find(t_s);
  if (place.handover != nullptr) return place.handover->value_um(place.t_s);
  if (place.transition != nullptr) return place.transition->value_um(place.t_s);
  if (place.segment == segments_.size()) return end_um_;
  return controller::value_um(segments_[place.segment].shape, place.t_s);
}

Motion Trajectory::motion(double t_s) const {
  if (live_) return to_goal_.at(t_s - live_since_s_);
  const Motion followed = motion_of_segments(t_s);
  if (!is_joining(t_s)) return followed;
  const Motion share = joining_->share.at(t_s - joining_->since_s);
  const double way_um = followed.value_um - joining_->from_um;
  return {.value_um = joining_->from_um + share.value_um * way_um,
          .velocity_um_per_s = share.velocity_um_per_s * way_um + share.value_um * followed.velocity_um_per_s,
          .acceleration_um_per_s2 = share.acceleration_um_per_s2 * way_um +
                                    2.0 * share.velocity_um_per_s * followed.velocity_um_per_s +
                                    share.value_um * followed.acceleration_um_per_s2};
}

Motion Trajectory::motion_of_segments(double t_s) const {
  const Place place = find(t_s);
  if (place.handover != nullptr) return place.handover->at(place.t_s);
  if (place.transition != nullptr) return place.transition->at(place.t_s);
  if (place.segment == segments_.size()) return {.value_um = end_um_};
  return controller::motion(segments_[place.segment].shape, place.t_s);
}

}  // namespace hystcan::controller
