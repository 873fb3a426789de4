// A sample of a twin's stage as a row of numbers, for SampleStream.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "can/scheduler.h"
#include "config/schema/config.h"
#include "twin/twin.h"

namespace hystcan::app {

struct SampleColumn {
  std::string_view name;
  std::string_view unit;  ///< "drive": the axis's drive unit; empty: none
};

inline constexpr auto truth_columns = std::to_array<SampleColumn>({
    {"sync_counter", ""},
    {"time_s", "s"},
    {"axis", ""},
    {"setpoint", "drive"},
    {"driven", "drive"},
    {"hysteresis_um", "um"},
    {"position_um", "um"},
    {"measured_um", "um"},
});

using TruthSample = std::array<double, truth_columns.size()>;

/// Times count from `started`.
TruthSample sample_of(const twin::Truth& truth, can::Time started);

/// The first line of the stream.
nlohmann::json stream_greeting(const config::Config& config, const twin::Config& twin);

}  // namespace hystcan::app
