// A cycle of an axis as a row of numbers, for SampleStream.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "config/schema/config.h"
#include "controller/cycle_record.h"

namespace hystcan::app {

/// Of controller/cycle_record.h, in the order of the stream. A later version adds at the end only.
inline constexpr auto streamed_columns = std::to_array<std::string_view>(
    {"cycle", "time_s", "axis", "state", "fault", "limits", "sample_missing", "segment", "shape_time_s",
     "reference_um", "position_um", "demand_um", "learnt_um", "drive", "amplifier_output", "turnaround_us",
     "lateness_us", "scan_line", "scan_pixel"});

using CycleSample = std::array<double, streamed_columns.size()>;

/// NaN where a cycle has no such value.
CycleSample sample_of(const controller::CycleRecord& record);

/// The first line of the stream: columns, rate, axes, and the words of states, faults and limits by their number.
nlohmann::json stream_greeting(const config::Config& config);

}  // namespace hystcan::app
