#include "controller/reference/trajectory.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::controller {

Trajectory::Trajectory(std::vector<Segment> segments, bool repeat, const ReferenceLimits& limits,
                       const TransitionLimits& transition_limits)
    : segments_(std::move(segments)),
      repeat_(repeat),
      limits_(limits),
      transition_limits_(transition_limits) {
  for (Segment& segment : segments_) segment.shape = prepared(std::move(segment.shape));
  if (!segments_.empty())
    end_um_ = controller::value_um(segments_.back().shape, duration_s(segments_.back().shape));
  entries_.reserve(segments_.size());
  begins_s_.reserve(segments_.size());
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
  if (segments_.empty())
    end_um_ = start_um;
  else
    first_entry_ = Handover(Transition::within(limits_of_transitions(), {.value_um = start_um},
                                               controller::value_um(segments_.front().shape, 0.0),
                                               usual_transition_s()));
}

void Trajectory::continue_from(const Trajectory& before, double t_s, double previewed_s) {
  if (segments_.empty())
    end_um_ = before.value_um(t_s + previewed_s);
  else
    first_entry_ = braked(before, t_s, previewed_s, controller::value_um(segments_.front().shape, 0.0));
  begin_s_ = t_s;
  live_ = false;
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

/// Finds the place at `t_s`; it is after the last segment where all are finished.
Trajectory::Place Trajectory::find(double t_s) const {
  if (segments_.empty()) return {};
  t_s -= begin_s_;
  if (t_s < first_entry_.duration_s()) return {.handover = &first_entry_, .segment = 0, .t_s = t_s};
  t_s -= first_entry_.duration_s();  // since the first shape's beginning
  if (t_s >= rest_of_pass_s_) {
    if (!repeat_) return {.segment = segments_.size()};
    const Transition& entry = entries_.front();
    t_s = std::fmod(t_s - rest_of_pass_s_, rest_of_pass_s_ + entry.duration_s());
    if (t_s < entry.duration_s()) return {.transition = &entry, .segment = 0, .t_s = t_s};
    t_s -= entry.duration_s();
  }
  const auto next = std::upper_bound(begins_s_.begin() + 1, begins_s_.end(), t_s);
  const auto i = static_cast<std::size_t>(next - begins_s_.begin() - 1);
  t_s -= begins_s_[i];
  if (i == 0) return {.segment = 0, .t_s = t_s};
  const Transition& entry = entries_[i];
  if (t_s < entry.duration_s()) return {.transition = &entry, .segment = i, .t_s = t_s};
  return {.segment = i, .t_s = t_s - entry.duration_s()};
}

Trajectory::Point Trajectory::at(double t_s) const {
  if (live_) {
    const double on_way_s = t_s - live_since_s_;
    const bool arrived = on_way_s >= to_goal_.duration_s();
    return {.value_um = to_goal_.value_um(on_way_s),
            .segment = segments_.size(),
            .in_transition = !arrived,
            .live = true,
            .at_rest = arrived,
            .shape_time_s = arrived ? on_way_s - to_goal_.duration_s() : 0.0};
  }
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
  }
  return point;
}

double Trajectory::value_um(double t_s) const {
  if (live_) return to_goal_.value_um(t_s - live_since_s_);
  const Place place = find(t_s);
  if (place.handover != nullptr) return place.handover->value_um(place.t_s);
  if (place.transition != nullptr) return place.transition->value_um(place.t_s);
  if (place.segment == segments_.size()) return end_um_;
  return controller::value_um(segments_[place.segment].shape, place.t_s);
}

Motion Trajectory::motion(double t_s) const {
  if (live_) return to_goal_.at(t_s - live_since_s_);
  const Place place = find(t_s);
  if (place.handover != nullptr) return place.handover->at(place.t_s);
  if (place.transition != nullptr) return place.transition->at(place.t_s);
  if (place.segment == segments_.size()) return {.value_um = end_um_};
  return controller::motion(segments_[place.segment].shape, place.t_s);
}

}  // namespace hystcan::controller
