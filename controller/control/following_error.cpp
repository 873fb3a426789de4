#include "controller/control/following_error.h"

#include <cmath>

namespace hystcan::controller {

bool FollowingError::step(double reference_um, double position_um, double dt_s) {
  const double moved_um = std::abs(reference_um - last_reference_um_.value_or(reference_um));
  const double slope_um_per_s = dt_s > 0.0 ? moved_um / dt_s : 0.0;
  last_reference_um_ = reference_um;
  const double lag_s = std::chrono::duration<double>(config_.lag).count();
  // If a value is NaN, the comparison is false: the stage does not follow.
  const bool follows = std::abs(reference_um - position_um) <= config_.error_um + lag_s * slope_um_per_s;
  exceeded_in_a_row_ = follows ? 0 : exceeded_in_a_row_ + 1;
  return exceeded_in_a_row_ < config_.cycles;
}

namespace {

double seconds(std::chrono::nanoseconds duration) { return std::chrono::duration<double>(duration).count(); }

/// Tolerance in s for the comparison of an elapsed time with the window or the timeout. The elapsed time is a
/// sum of cycle times, each of which is rounded.
constexpr double rounding_s = 1e-9;

}  // namespace

Arrival InPosition::step(const Config& config, State& state, const Trajectory::Point& reference,
                         const std::optional<double>& position_um, double dt_s) {
  if (!reference.at_rest) {
    state = {};
    return state.arrival;
  }
  const bool settling = state.trying_s >= 0.0 && reference.value_um == state.reference_um;
  if (settling)
    state.trying_s += dt_s;
  else
    state = {.reference_um = reference.value_um, .trying_s = 0.0};
  if (position_um) {
    const bool was_within = state.within_s >= 0.0;
    const bool within = std::abs(reference.value_um - *position_um) <= config.tolerance_um;
    if (!within)
      state.within_s = -1.0;
    else
      state.within_s = was_within ? state.within_s + dt_s : 0.0;
    if (!within && state.arrival == Arrival::in_position) {
      state.arrival = Arrival::moving;
      state.trying_s = 0.0;
    }
  }
  if (state.within_s + rounding_s >= seconds(config.window))
    state.arrival = Arrival::in_position;
  else if (state.arrival == Arrival::moving && state.trying_s + rounding_s >= seconds(config.timeout))
    state.arrival = Arrival::failed;
  return state.arrival;
}

}  // namespace hystcan::controller
