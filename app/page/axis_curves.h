// Computes curves of an axis for the page, from the settings in force: hysteresis model and frequency
// response.
#pragma once

#include <nlohmann/json.hpp>

#include "config/schema/config.h"

namespace hystcan::app {

/// Returns the ascending and the descending reference curve of the controller's hysteresis model. Also
/// returns the delay in s from a drive to the sample that shows the resulting position.
nlohmann::json reference_curves_of(const config::AxisConfig& axis, double cycle_s);

/// Returns the Bode diagram of the control loop: open loop, sensitivity and closed loop from 0.1 Hz to half
/// the cycle rate, with the stability margins.
nlohmann::json bode_of(const config::AxisConfig& axis, double cycle_s);

}  // namespace hystcan::app
