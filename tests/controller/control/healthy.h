// The health of the nodes of an axis that is driven.
#pragma once

#include "controller/control/supervisor.h"

namespace hystcan::controller {

inline constexpr NodeHealth all_is_well{.sensor_alive = true,
                                        .sensor_operational = true,
                                        .amplifier_alive = true,
                                        .amplifier_operational = true,
                                        .amplifier_ready = true,
                                        .amplifier_enabled = true};

}  // namespace hystcan::controller
