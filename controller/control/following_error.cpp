#include "controller/control/following_error.h"

#include <cmath>

namespace hystcan::controller {

bool FollowingError::step(double reference_um, double position_um, double dt_s) {
  const double moved_um = std::abs(reference_um - last_reference_um_.value_or(reference_um));
  const double slope_um_per_s = dt_s > 0.0 ? moved_um / dt_s : 0.0;
  last_reference_um_ = reference_um;
  const double lag_s = std::chrono::duration<double>(config_.lag).count();
  // With NaN the comparison is false: the stage does not follow.
  const bool follows = std::abs(reference_um - position_um) <= config_.error_um + lag_s * slope_um_per_s;
  exceeded_in_a_row_ = follows ? 0 : exceeded_in_a_row_ + 1;
  return exceeded_in_a_row_ < config_.cycles;
}

}  // namespace hystcan::controller
