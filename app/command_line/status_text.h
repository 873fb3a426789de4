// The state of a running controller as lines of text.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/live/control_answers.h"
#include "app/page/bus_counters.h"

namespace hystcan::app {

/// "-" if there is no number.
std::string four_decimals(double value);

/// Counters, recording, a row for each axis. Not cut to any width.
std::vector<std::string> status_lines(const StatusAnswer& status);

/// The same for a screen: with timing, the last event of a node, and the interface, if there is one.
/// `status` may be empty: no answer has come, and `trouble` says why.
std::vector<std::string> status_screen(const std::optional<StatusAnswer>& status,
                                       const std::optional<BusReport>& bus, const std::string& trouble);

}  // namespace hystcan::app
