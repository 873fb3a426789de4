// Tracking results as text and JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "can/bus_health_log.h"
#include "can/protocol/e2e.h"
#include "controller/control/statistics.h"
#include "controller/cycle_record.h"
#include "controller/timing.h"

namespace hystcan::app {

/// Errors in the first 0.1 s of each segment of the reference are not counted.
inline constexpr double settle_s = 0.1;

nlohmann::json to_json(const controller::AxisOutcome& outcome);
/// Returns the whole reference, with each segment under "segments".
nlohmann::json to_json(const controller::TrackingStatistics& statistics, double stroke_um);
nlohmann::json to_json(const can::BusReport& report);
/// Returns the counts by cause.
nlohmann::json to_json(const can::RejectedFrames& rejected);

/// The report about the bus at the end of a run.
struct BusClosing {
  std::vector<std::string> events{};   ///< events of the nodes, worded as in the log
  std::uint64_t events_truncated = 0;  ///< number of events without a line
  can::BusReport bus{};
  std::vector<can::RejectedFrames> rejected{};
};
/// Returns lines: the events, the bus, and each message with rejected frames.
std::vector<std::string> describe(const BusClosing& closing);
/// Returns the bus, with each message and its causes under "rejected".
nlohmann::json to_json(const BusClosing& closing);

/// Returns an object with the keys period, wake_up, turnaround and execution.
nlohmann::json to_json(const controller::CycleTiming& timing);
std::vector<std::string> describe(const controller::CycleTiming& timing);

std::string describe(const controller::AxisOutcome& outcome);
/// Returns a line for each segment of the reference: its errors; settling time and overshoot of steps; the
/// noise at rest.
std::vector<std::string> describe_segments(const controller::AxisOutcome& outcome);
std::string describe(const std::string& axis, const controller::Fault& fault);
/// Returns the reason if a run has no errors to report: a fault, or an axis that tracked no sample; else
/// empty.
std::string failure_of(const std::vector<controller::AxisOutcome>& axes);

}  // namespace hystcan::app
