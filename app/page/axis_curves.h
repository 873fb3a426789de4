// The model and the loop of an axis with the settings in force, as curves for the page.
#pragma once

#include <nlohmann/json.hpp>

#include "config/schema/config.h"

namespace hystcan::app {

/// Returns the reference curves of the controller's model, and the delay from its drive to the sample of the
/// position.
nlohmann::json reference_curves_of(const config::AxisConfig& axis, double cycle_s);

/// Returns the open loop, the sensitivity and the closed loop up to half the rate, and the margins.
nlohmann::json bode_of(const config::AxisConfig& axis, double cycle_s);

}  // namespace hystcan::app
