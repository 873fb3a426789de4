// How tracking results are shown.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "can/integrity.h"
#include "controller/bus_log.h"
#include "controller/statistics.h"

namespace hystcan::app {

/// Errors of the first 0.1 s of each segment of the reference are not counted.
inline constexpr double settle_s = 0.1;

nlohmann::json to_json(const controller::AxisOutcome& outcome);
nlohmann::json to_json(const controller::BusReport& report);
/// Frames in the place of a message that were not taken for it, by cause.
nlohmann::json to_json(const can::Checker& checker);
std::string describe(const controller::AxisOutcome& outcome);
std::string describe(const std::string& axis, const controller::Fault& fault);

}  // namespace hystcan::app
