#include "controller/control/course.h"

#include <algorithm>

namespace hystcan::controller {
namespace {

/// Reversals that it remembers; deeper ones are merged.
constexpr std::size_t capacity = 64;

}  // namespace

Course::Course(const model::HysteresisParameters& parameters, const Delays& delays)
    : model_(parameters),
      delays_(delays),
      at_upper_(model_.at_upper_threshold(capacity)),
      at_lower_(model_.virgin(model_.input_range().lo, capacity)),
      memories_{at_upper_, at_lower_} {}

void Course::restart(double drive) {
  memories_ = {at_upper_, at_lower_};
  for (std::size_t i = 0; i < memories_.size(); ++i) {
    const double position_um = model_.advance(memories_[i], drive).value;
    mark_.positions[i] = {position_um, position_um};
  }
}

void Course::step(double drive, double dt_s, double cycle_s) {
  const double late_s = delays_.to_sample_s(cycle_s) + 2.0 * cycle_s;
  for (std::size_t i = 0; i < memories_.size(); ++i) {
    Mark::Position& position = mark_.positions[i];
    position.now_um = model_.advance(memories_[i], drive).value;
    position.slow_um += (position.now_um - position.slow_um) * dt_s / (dt_s + late_s);
  }
}

model::Interval Course::moved_um(const Mark& since) const {
  std::array<double, 4> moved{};
  for (std::size_t i = 0; i < mark_.positions.size(); ++i) {
    moved[2 * i] = mark_.positions[i].now_um - since.positions[i].now_um;
    moved[2 * i + 1] = mark_.positions[i].slow_um - since.positions[i].slow_um;
  }
  const auto [least, most] = std::ranges::minmax(moved);
  return {least, most};
}

}  // namespace hystcan::controller
