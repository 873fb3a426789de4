// Converts records to rows of numbers for SampleStream. A row is a cycle of an axis (controller) or a sample
// of a simulated stage (twin).
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

/// The columns that a controller streams, in this order; controller/cycle_record.h describes them. A later
/// version may add columns only at the end, so that older clients can still read the stream.
inline constexpr auto streamed_columns = std::to_array<std::string_view>(
    {"cycle", "time_s", "axis", "state", "fault", "limits", "sample_missing", "segment", "shape_time_s",
     "reference_um", "position_um", "demand_um", "learnt_um", "drive", "amplifier_output", "turnaround_us",
     "lateness_us", "scan_line", "scan_pixel"});

/// Name and unit of each column that a twin streams. The unit "drive" means the drive unit of the axis.
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

/// Returns the stream row of a controller cycle. A column is NaN if the cycle has no such value.
std::array<double, streamed_columns.size()> sample_of(const controller::CycleRecord& record);
/// Returns the stream row of a twin sample. The column time_s counts from `started`.
std::array<double, truth_columns.size()> sample_of(const twin::Truth& truth, can::Time started);

struct StreamColumn {
  std::string name;
  std::string unit{};
};
template <class V>
void visit(V& v, StreamColumn& c) {
  v.member("name", c.name, {"", "name"});
  v.member("unit", c.unit, {"", "unit of the column; `drive` means the drive unit of the axis"});
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
             {"um",
              "only in the stream of a controller: `tolerance_um` of `[axis.control.in_position]`; 0 without "
              "this table"});
}

/// The first line of a stream, which describes its rows.
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
  v.member("columns", g.columns, {"", "columns of each row, in order"});
  v.member("axes", g.axes, {"", "list of the axes; the column `axis` is the index in this list, from 0"});
  v.optional("states", g.states, !g.states.empty(),
             {"",
              "only in the stream of a controller: list of words; the column `state` is the index in this "
              "list, from 0"});
  v.optional("faults", g.faults, !g.faults.empty(),
             {"",
              "only in the stream of a controller: list of words; the column `fault` is the index in this "
              "list, from 0"});
  v.optional(
      "limits", g.limits, !g.limits.empty(),
      {"",
       "only in the stream of a controller: list of words; bit n of the column `limits` means word n of "
       "this list, from 0"});
}

/// Returns the first line of the stream: of a controller, or of a twin if `twin` is given.
StreamGreeting stream_greeting(const config::Config& config);
StreamGreeting stream_greeting(const config::Config& config, const twin::Config& twin);

}  // namespace hystcan::app
