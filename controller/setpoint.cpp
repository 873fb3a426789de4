#include "controller/setpoint.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace hystcan::controller {
namespace {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;  // clang 14 does not deduce it

double blend(double from, double to, double s) { return from + (to - from) * s; }

/// Position within the present cycle, 0..1; exactly 0 at the end of the last one.
template <class Periodic>
double phase(const Periodic& shape, double t_s) {
  const double cycles = std::clamp(t_s * shape.frequency_Hz, 0.0, shape.cycles);
  return cycles - std::floor(cycles);
}

double staircase_value(const Staircase& stairs, double t_s) {
  const double step_s = stairs.rise_s + stairs.dwell_s;
  const double last = static_cast<double>(stairs.levels_um.size() - 1);
  const double step = std::clamp(std::floor(t_s / step_s), 0.0, last);
  const auto i = static_cast<std::size_t>(step);
  if (i == 0 || stairs.rise_s == 0.0) return stairs.levels_um[i];
  return blend(stairs.levels_um[i - 1], stairs.levels_um[i],
               smooth_step((t_s - step * step_s) / stairs.rise_s));
}

}  // namespace

std::string to_string(const Shape& shape) {
  return std::visit(Overloaded{[](const Hold&) { return "hold"; }, [](const Ramp&) { return "ramp"; },
                               [](const Triangle&) { return "triangle"; }, [](const Sine&) { return "sine"; },
                               [](const Staircase&) { return "staircase"; }},
                    shape);
}

double duration_s(const Shape& shape) {
  return std::visit(
      Overloaded{[](const Hold& s) { return s.duration_s; }, [](const Ramp& s) { return s.duration_s; },
                 [](const Triangle& s) { return s.cycles / s.frequency_Hz; },
                 [](const Sine& s) { return s.cycles / s.frequency_Hz; },
                 [](const Staircase& s) {
                   return static_cast<double>(s.levels_um.size()) * (s.rise_s + s.dwell_s);
                 }},
      shape);
}

double value_um(const Shape& shape, double t_s) {
  return std::visit(Overloaded{[](const Hold& s) { return s.level_um; },
                               [&](const Ramp& s) {
                                 return blend(s.from_um, s.to_um, std::clamp(t_s / s.duration_s, 0.0, 1.0));
                               },
                               [&](const Triangle& s) {
                                 return blend(s.low_um, s.high_um, 1.0 - std::abs(2.0 * phase(s, t_s) - 1.0));
                               },
                               [&](const Sine& s) {
                                 const double angle = 2.0 * std::numbers::pi * phase(s, t_s);
                                 return blend(s.low_um, s.high_um, 0.5 * (1.0 - std::cos(angle)));
                               },
                               [&](const Staircase& s) { return staircase_value(s, t_s); }},
                    shape);
}

double smooth_step(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
}

Trajectory::Trajectory(std::vector<Segment> segments, bool repeat)
    : segments_(std::move(segments)), repeat_(repeat) {
  for (const Segment& segment : segments_) length_s_ += segment.transition_s + duration_s(segment.shape);
  if (!segments_.empty()) end_um_ = value_um(segments_.back().shape, duration_s(segments_.back().shape));
}

void Trajectory::start_from(double start_um) { start_um_ = start_um; }

Trajectory::Point Trajectory::at(double t_s) const {
  double from_um = start_um_;
  if (repeat_ && t_s >= length_s_) {
    t_s = std::fmod(t_s, length_s_);
    from_um = end_um_;
  }
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const auto& [shape, transition_s] = segments_[i];
    if (t_s < transition_s)
      return {.value_um = blend(from_um, value_um(shape, 0.0), smooth_step(t_s / transition_s)),
              .segment = i,
              .in_transition = true};
    t_s -= transition_s;
    const double length_s = duration_s(shape);
    if (t_s < length_s) return {.value_um = value_um(shape, t_s), .segment = i, .shape_time_s = t_s};
    t_s -= length_s;
    from_um = value_um(shape, length_s);
  }
  return {.value_um = from_um, .segment = segments_.size(), .finished = true};
}

}  // namespace hystcan::controller
