// Model and loop of an axis with the settings in force, as curves for the page.
#pragma once

#include <nlohmann/json.hpp>

#include "config/schema/config.h"

namespace hystcan::app {

/// The reference curves of the controller's model, and how much later than its drive a position is sampled.
nlohmann::json reference_curves_of(const config::AxisConfig& axis, double cycle_s);

/// The open loop, the sensitivity and the closed loop up to half the rate, and the margins.
nlohmann::json bode_of(const config::AxisConfig& axis, double cycle_s);

}  // namespace hystcan::app
