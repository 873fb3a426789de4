// A control law whose hysteresis memory was erased, as when an axis begins to track.
#pragma once

#include "controller/control/law.h"

namespace hystcan::support {

/// Calls ControlLaw::restart() after a drive to the lower threshold.
inline double restart_at_lower_threshold(controller::ControlLaw& law, double position_um) {
  law.follow(law.model().input_range().lo);
  return law.restart(position_um);
}

}  // namespace hystcan::support
