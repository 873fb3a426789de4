// A cycle of an axis as a row of numbers, for SampleStream.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>

#include "config/schema/config.h"
#include "controller/cycle_record.h"

namespace hystcan::app {

struct SampleColumn {
  std::string_view name;
  std::string_view unit;  ///< "drive": the axis's drive unit; empty: none
};

nlohmann::json columns_to_json(std::span<const SampleColumn> columns);

inline constexpr auto cycle_columns = std::to_array<SampleColumn>({
    {"cycle", ""},           {"time_s", "s"},       {"axis", ""},
    {"state", ""},           {"fault", ""},         {"limits", ""},
    {"sample_missing", ""},  {"segment", ""},       {"shape_time_s", "s"},
    {"reference_um", "um"},  {"position_um", "um"}, {"demand_um", "um"},
    {"learnt_um", "um"},     {"drive", "drive"},    {"amplifier_output", "drive"},
    {"turnaround_us", "us"}, {"lateness_us", "us"}, {"scan_line", ""},
    {"scan_pixel", ""},
});

using CycleSample = std::array<double, cycle_columns.size()>;

/// NaN where a cycle has no such value.
CycleSample sample_of(const controller::CycleRecord& record);

/// The first line of the stream: columns, rate, axes, and the words of states, faults and limits by their number.
nlohmann::json stream_greeting(const config::Config& config);

}  // namespace hystcan::app
