// Formats states and counters for Prometheus and similar monitoring programs. The format is OpenMetrics
// (https://openmetrics.io), or the older text format of Prometheus, which lacks the types stateset and info.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "app/live/control_answers.h"
#include "app/page/bus_counters.h"
#include "app/page/page_clients.h"
#include "metrics/statistics.h"

namespace hystcan::app {

/// Returns true if the request header `accept` allows the OpenMetrics format.
bool accepts_open_metrics(std::string_view accept);
const char* metrics_type(bool is_open);

/// Returns the states and counters as text. `is_open`: true for OpenMetrics, false for the older format.
/// `status`: the status of the controller; nullopt if it is unknown or too old. `age_s`: time since the
/// controller's last answer; infinite if it never answered.
std::string metrics_text(bool is_open, const std::optional<StatusAnswer>& status, double age_s,
                         const BusReport& bus, const metrics::Histogram& turnaround,
                         const metrics::Histogram& lateness, const PageCounters& page);

}  // namespace hystcan::app
