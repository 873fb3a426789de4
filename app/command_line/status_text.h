// Formats the status of a running controller as lines of text.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/live/control_answers.h"
#include "app/page/bus_counters.h"

namespace hystcan::app {

/// Formats the value with four decimals; "-" if it is NaN.
std::string four_decimals(double value);

/// Returns a line with the cycle counters (cycles, missed cycles, missing and late samples), a line about the
/// recording if there is one, and a line for each axis. Lines may be wider than the terminal.
std::vector<std::string> status_lines(const StatusAnswer& status);

/// Returns status_lines() with additional lines for a screen: the cycle timing (period, lateness, turnaround
/// and execution), the last event of a node, and the CAN interface if `bus` is given. If the controller did
/// not answer, `status` is nullopt and `error` is the reason.
std::vector<std::string> status_screen(const std::optional<StatusAnswer>& status,
                                       const std::optional<BusReport>& bus, const std::string& error);

}  // namespace hystcan::app
