// The loop of an axis with the settings in force, as curves (docs/page_protocol.md).
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "config/schema/config.h"

namespace hystcan::app {

nlohmann::json bode_of(const config::AxisConfig& axis, double cycle_s);

}  // namespace hystcan::app
