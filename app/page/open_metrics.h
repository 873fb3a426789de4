// States and counters as OpenMetrics text, for Prometheus and others (https://openmetrics.io).
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/page/timing_histogram.h"

namespace hystcan::app {

struct PageCounters {
  std::uint64_t clients = 0;
  std::uint64_t cut_off = 0;
  std::uint64_t refused = 0;
  std::uint64_t lost_rows = 0;
};

inline constexpr const char* open_metrics_type = "application/openmetrics-text; version=1.0.0; charset=utf-8";

/// `status`: the answer of the control socket, or null. `states`: all there are; null if not known. `bus`: as
/// BusCounters::report().
std::string open_metrics(const nlohmann::json& status, const nlohmann::json& states,
                         const nlohmann::json& bus, const TimingHistogram& turnaround,
                         const TimingHistogram& lateness, const PageCounters& page);

}  // namespace hystcan::app
