// Formats tracking results as text and JSON.
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

/// Errors in the first 0.1 s of each reference segment do not count in the error statistics, because the
/// control loop settles in this time.
inline constexpr double settle_s = 0.1;

nlohmann::json to_json(const controller::AxisOutcome& outcome);
/// Returns the tracking errors over the whole reference, and the errors of each segment under "segments".
nlohmann::json to_json(const controller::TrackingStatistics& statistics, double stroke_um);
nlohmann::json to_json(const can::BusReport& report);
/// Returns the number of rejected frames by the cause of the rejection.
nlohmann::json to_json(const can::RejectedFrames& rejected);

/// The report about the bus, written at the end of a run.
struct BusClosing {
  std::vector<std::string> events{};   ///< one line for each kind of node event, worded as in the log
  std::uint64_t events_truncated = 0;  ///< number of node events without a line in `events`
  can::BusReport bus{};
  std::vector<can::RejectedFrames> rejected{};
};
/// Returns the report as lines: the node events, the bus, and each message with rejected frames.
std::vector<std::string> describe(const BusClosing& closing);
/// Returns the report about the bus. The member "rejected" lists each message with its causes of rejection.
nlohmann::json to_json(const BusClosing& closing);

/// Returns a JSON object with the statistics of period, wake_up, turnaround and execution.
nlohmann::json to_json(const controller::CycleTiming& timing);
std::vector<std::string> describe(const controller::CycleTiming& timing);
/// Returns the numbers of cycles, missed cycles, and missing and late samples.
std::string describe(const controller::CycleCounters& counters);

std::string describe(const controller::AxisOutcome& outcome);
/// Returns a line for each segment of the reference: its errors, the settling time and overshoot of its
/// steps, and the noise at rest.
std::vector<std::string> describe_segments(const controller::AxisOutcome& outcome);
std::string describe(const std::string& axis, const controller::Fault& fault);
/// Returns the reason for a failed run: a fault, or an axis that tracked no sample. Returns an empty text if
/// the run was successful.
std::string failure_of(const std::vector<controller::AxisOutcome>& axes);

}  // namespace hystcan::app
