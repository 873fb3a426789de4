// Model and loop of an axis with the settings in force, as curves (docs/page_protocol.md).
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "config/schema/config.h"

namespace hystcan::app {

/// The reference curves of the controller's model, and how much later than its drive a position is sampled.
nlohmann::json reference_curves_of(const config::AxisConfig& axis, double cycle_s);

nlohmann::json bode_of(const config::AxisConfig& axis, double cycle_s);

}  // namespace hystcan::app
