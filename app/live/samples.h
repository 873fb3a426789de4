// Rows of numbers for SampleStream: a cycle of an axis, a sample of a twin's stage.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "can/scheduler.h"
#include "config/schema/config.h"
#include "controller/cycle_record.h"
#include "twin/twin.h"

namespace hystcan::app {

/// Of controller/cycle_record.h, in the order of the stream. A later version adds at the end only.
inline constexpr auto streamed_columns = std::to_array<std::string_view>(
    {"cycle", "time_s", "axis", "state", "fault", "limits", "sample_missing", "segment", "shape_time_s",
     "reference_um", "position_um", "demand_um", "learnt_um", "drive", "amplifier_output", "turnaround_us",
     "lateness_us", "scan_line", "scan_pixel"});

/// Name and unit; "drive" is the axis's drive unit.
inline constexpr auto truth_columns = std::to_array<std::pair<std::string_view, std::string_view>>({
    {"sync_counter", ""},
    {"time_s", "s"},
    {"axis", ""},
    {"setpoint", "drive"},
    {"driven", "drive"},
    {"hysteresis_um", "um"},
    {"position_um", "um"},
    {"measured_um", "um"},
});

/// NaN where a cycle has no such value.
std::array<double, streamed_columns.size()> sample_of(const controller::CycleRecord& record);
/// Times count from `started`.
std::array<double, truth_columns.size()> sample_of(const twin::Truth& truth, can::Time started);

/// The first line of the stream of a controller: columns, rate, axes, and the words of states, faults and
/// limits by their number; and of that of a twin.
nlohmann::json stream_greeting(const config::Config& config);
nlohmann::json stream_greeting(const config::Config& config, const twin::Config& twin);

}  // namespace hystcan::app
