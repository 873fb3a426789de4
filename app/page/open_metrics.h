// States and counters for Prometheus and others: as OpenMetrics text (https://openmetrics.io), or in the
// older text format of Prometheus, which knows neither stateset nor info.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "app/page/page_clients.h"
#include "metrics/statistics.h"

namespace hystcan::app {

enum class MetricsFormat : std::uint8_t { prometheus, open_metrics };
/// What a client that sends this header `Accept` understands.
MetricsFormat metrics_format_for(std::string_view accept);
const char* content_type(MetricsFormat format);

/// What the page knows of the controller.
struct KnownStatus {
  const nlohmann::json& status;  ///< the answer of the control socket; null: none, or too old
  double age_s;                  ///< since the last answer; infinite: none yet
};

/// `states`: all there are; null if not known. `bus`: as BusCounters::report().
std::string metrics_text(MetricsFormat format, const KnownStatus& known, const nlohmann::json& states,
                         const nlohmann::json& bus, const metrics::Histogram& turnaround,
                         const metrics::Histogram& lateness, const PageCounters& page);

}  // namespace hystcan::app
