// States and counters for Prometheus and similar programs: as OpenMetrics text (https://openmetrics.io), or
// in the older text format of Prometheus, which has neither stateset nor info.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "app/live/control_answers.h"
#include "app/page/bus_counters.h"
#include "app/page/page_clients.h"
#include "metrics/statistics.h"

namespace hystcan::app {

/// Returns true if a client with this header `Accept` supports OpenMetrics.
bool accepts_open_metrics(std::string_view accept);
const char* metrics_type(bool is_open);

/// Returns the text. `is_open`: as OpenMetrics. `status`: state of the controller; nullopt if there is none
/// or it is too old. `age_s`: time since the last answer; infinite if there was none.
std::string metrics_text(bool is_open, const std::optional<StatusAnswer>& status, double age_s,
                         const BusReport& bus, const metrics::Histogram& turnaround,
                         const metrics::Histogram& lateness, const PageCounters& page);

}  // namespace hystcan::app
