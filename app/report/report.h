// How tracking results are shown.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "can/bus_health_log.h"
#include "can/protocol/e2e.h"
#include "controller/control/statistics.h"
#include "controller/timing.h"

namespace hystcan::app {

/// Errors of the first 0.1 s of each segment of the reference are not counted.
inline constexpr double settle_s = 0.1;

nlohmann::json to_json(const controller::AxisOutcome& outcome);
nlohmann::json to_json(const can::BusReport& report);
/// By cause.
nlohmann::json to_json(const can::RejectedFrames& rejected);

/// What there is to tell of the bus when a run on it has ended.
struct BusClosing {
  std::vector<std::string> events{};  ///< what the nodes said, as the log had it
  can::BusReport bus{};
  std::vector<can::RejectedFrames> rejected{};
};
/// Events, the bus, and a line for each message that was rejected.
std::vector<std::string> describe(const BusClosing& closing);
/// The bus, and under "rejected" every message with its causes.
nlohmann::json to_json(const BusClosing& closing);

/// By period, wake_up, turnaround and execution.
nlohmann::json to_json(const controller::CycleTiming& timing);
std::vector<std::string> describe(const controller::CycleTiming& timing);

std::string describe(const controller::AxisOutcome& outcome);
std::string describe(const std::string& axis, const controller::Fault& fault);

}  // namespace hystcan::app
