// States and counters for Prometheus and others: as OpenMetrics text (https://openmetrics.io), or in the
// older text format of Prometheus, which knows neither stateset nor info.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "app/live/control_answers.h"
#include "app/page/bus_counters.h"
#include "app/page/page_clients.h"
#include "metrics/statistics.h"

namespace hystcan::app {

/// Whether a client that sends this header `Accept` understands OpenMetrics.
bool accepts_open_metrics(std::string_view accept);
const char* metrics_type(bool is_open);

/// `is_open`: as OpenMetrics. `status`: of the controller; empty: none, or too old. `age_s`: since the last
/// answer; infinite: none yet.
std::string metrics_text(bool is_open, const std::optional<StatusAnswer>& status, double age_s,
                         const BusReport& bus, const metrics::Histogram& turnaround,
                         const metrics::Histogram& lateness, const PageCounters& page);

}  // namespace hystcan::app
