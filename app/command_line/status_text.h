// The state of a running controller as lines of text.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/live/control_answers.h"
#include "app/page/bus_counters.h"

namespace hystcan::app {

/// Formats the value; "-" if it is NaN.
std::string four_decimals(double value);

/// Returns lines with the counters and the recording, and a line for each axis. The lines can have any width.
std::vector<std::string> status_lines(const StatusAnswer& status);

/// Like status_lines(), for a screen: adds timing, the last event of a node, and the interface, if given. If
/// no answer arrived, `status` is nullopt and `error` is the reason.
std::vector<std::string> status_screen(const std::optional<StatusAnswer>& status,
                                       const std::optional<BusReport>& bus, const std::string& error);

}  // namespace hystcan::app
