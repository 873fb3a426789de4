// Rows of numbers for SampleStream: a cycle of an axis, or a sample of a twin's stage.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/scheduler.h"
#include "config/schema/config.h"
#include "controller/cycle_record.h"
#include "twin/twin.h"

namespace hystcan::app {

/// Columns of controller/cycle_record.h, in the order of the stream. A later version adds columns only at the
/// end.
inline constexpr auto streamed_columns = std::to_array<std::string_view>(
    {"cycle", "time_s", "axis", "state", "fault", "limits", "sample_missing", "segment", "shape_time_s",
     "reference_um", "position_um", "demand_um", "learnt_um", "drive", "amplifier_output", "turnaround_us",
     "lateness_us", "scan_line", "scan_pixel"});

/// Name and unit of each column; the unit "drive" means the axis's drive unit.
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

/// Returns the row of a cycle. A column is NaN if the cycle has no such value.
std::array<double, streamed_columns.size()> sample_of(const controller::CycleRecord& record);
/// Returns the row of a sample. Its time counts from `started`.
std::array<double, truth_columns.size()> sample_of(const twin::Truth& truth, can::Time started);

struct StreamColumn {
  std::string name;
  std::string unit{};
};
template <class V>
void visit(V& v, StreamColumn& c) {
  v.member("name", c.name, {"", "name"});
  v.member("unit", c.unit, {"", "unit; `drive`: the drive unit of the axis"});
}

struct StreamAxis {
  std::string name;
  std::string drive_unit{};
  std::optional<double> tolerance_um{};
};
template <class V>
void visit(V& v, StreamAxis& a) {
  v.member("name", a.name, {"", "name in the configuration"});
  v.member("drive_unit", a.drive_unit, {"", "unit of its drive"});
  v.optional("tolerance_um", a.tolerance_um, a.tolerance_um.has_value(),
             {"um", "controller: tolerance of `[axis.control.in_position]`, or 0"});
}

/// The first line of a stream.
struct StreamGreeting {
  std::string stream{};
  std::uint64_t version = 1;
  double rate_Hz = 0.0;
  std::vector<StreamColumn> columns{};
  std::vector<StreamAxis> axes{};
  std::vector<std::string> states{}, faults{}, limits{};
};
template <class V>
void visit(V& v, StreamGreeting& g) {
  v.member("stream", g.stream, {"", "`controller` or `twin`"});
  v.member("version", g.version, {"", "1"});
  v.member("rate_Hz", g.rate_Hz, {"Hz", "rate of the cycles"});
  v.member("columns", g.columns, {"", "the numbers of a row"});
  v.member("axes", g.axes, {"", "each axis; the column `axis` is its index"});
  v.optional("states", g.states, !g.states.empty(),
             {"", "controller: words for the indices in the column `state`"});
  v.optional("faults", g.faults, !g.faults.empty(),
             {"", "controller: words for the indices in the column `fault`"});
  v.optional("limits", g.limits, !g.limits.empty(),
             {"", "controller: words for the bits in the column `limits`"});
}

/// Returns the first line of the stream, for a controller and for a twin.
StreamGreeting stream_greeting(const config::Config& config);
StreamGreeting stream_greeting(const config::Config& config, const twin::Config& twin);

}  // namespace hystcan::app
