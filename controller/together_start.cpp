#include "controller/together_start.h"

#include <algorithm>
#include <initializer_list>

namespace hystcan::controller {
namespace {

bool some_are_in(std::initializer_list<AxisState> states, const WiredAxes& axes) {
  return std::ranges::any_of(axes, [&](const auto& wired) {
    return std::ranges::find(states, wired->axis.state()) != states.end();
  });
}

}  // namespace

void TogetherStart::step(const WiredAxes& axes, can::Time now, double reference_s) {
  if (some_are_in({AxisState::tracking}, axes)) return ready_since_.reset();
  tracking_since_s_.reset();
  if (!some_are_in({AxisState::ready}, axes)) return ready_since_.reset();
  if (!ready_since_) ready_since_ = now;
  const bool waits = config_.waits && now - *ready_since_ < config_.timeout &&
                     some_are_in({AxisState::waiting, AxisState::initialising}, axes);
  if (!waits) tracking_since_s_ = reference_s;
}

}  // namespace hystcan::controller
