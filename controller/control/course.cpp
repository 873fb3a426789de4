#include "controller/control/course.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace hystcan::controller {
namespace {

/// Maximum number of branches in a memory of the model. If a memory is full, a further reversal adds no
/// branch.
constexpr std::size_t capacity = 64;

}  // namespace

Course::Course(const model::HysteresisParameters& parameters, const Delays& delays)
    : model_(parameters),
      delays_(delays),
      at_thresholds_{model_.at_upper_threshold(capacity), model_.virgin(model_.input_range().lo, capacity)},
      memories_(at_thresholds_) {}

void Course::restart(double drive) {
  memories_ = at_thresholds_;
  Positions now{};
  for (std::size_t i = 0; i < memories_.size(); ++i)
    now[i] = mark_[i] = mark_[2 + i] = model_.advance(memories_[i], drive).value;
  under_way_ = {};
  under_way_.past.fill(now);
}

void Course::follow(double drive) {
  for (std::size_t i = 0; i < memories_.size(); ++i) mark_[i] = model_.advance(memories_[i], drive).value;
}

void Course::elapse(double dt_s, double cycle_s) {
  if (cycle_s != cycle_s_) plan(cycle_s);
  const Positions late = delayed({mark_[0], mark_[1]}, dt_s);
  const double share = dt_s / (dt_s + lag_s_);
  for (std::size_t i = 0; i < late.size(); ++i) mark_[2 + i] += (late[i] - mark_[2 + i]) * share;
}

/// Sets the time between two stored positions: one cycle. If the pure delays are longer than 31 cycles, sets
/// a 31st of the delays, so that the 32 stored positions cover them.
void Course::plan(double cycle_s) {
  cycle_s_ = cycle_s;
  const double pure_s = delays_.pure_s();
  lag_s_ = delays_.to_sample_s(cycle_s) - pure_s + 2.0 * cycle_s;
  apart_s_ = std::max(cycle_s, pure_s / static_cast<double>(under_way_.past.size() - 1));
  ago_ = static_cast<std::size_t>(std::round(pure_s / apart_s_));
}

/// Stores the present positions. Returns older stored positions: their age is the sum of the pure delays.
Course::Positions Course::delayed(const Positions& now, double dt_s) {
  auto& [past, newest, since_newest_s] = under_way_;
  for (since_newest_s += dt_s; since_newest_s >= 0.5 * apart_s_; since_newest_s -= apart_s_) {
    newest = (newest + 1) % past.size();
    past[newest] = now;
  }
  return past[(newest + past.size() - ago_) % past.size()];
}

model::Interval Course::moved_um(const Mark& since) const {
  Mark moved{};
  std::ranges::transform(mark_, since, moved.begin(), std::minus{});
  const auto [least, most] = std::ranges::minmax(moved);
  return {least, most};
}

}  // namespace hystcan::controller
