#include "app/live/samples.h"

#include <algorithm>
#include <string>
#include <vector>

#include "controller/control/statistics.h"
#include "controller/cycle_record.h"

namespace hystcan::app {
namespace {

const auto& columns() {
  static const auto found = [] {
    std::array<const controller::CycleColumn*, streamed_columns.size()> all{};
    std::ranges::transform(streamed_columns, all.begin(), controller::find_cycle_column);
    return all;
  }();
  return found;
}

std::vector<std::string> words_of(std::string_view column) {
  return controller::words_of(*controller::find_cycle_column(column));
}

}  // namespace

std::array<double, streamed_columns.size()> sample_of(const controller::CycleRecord& record) {
  std::array<double, streamed_columns.size()> sample{};
  std::ranges::transform(columns(), sample.begin(),
                         [&](const controller::CycleColumn* column) { return column->value(record); });
  return sample;
}

std::array<double, truth_columns.size()> sample_of(const twin::Truth& truth, can::Time started) {
  return {static_cast<double>(truth.sync_counter),
          can::seconds(truth.time - started),
          static_cast<double>(truth.axis),
          truth.setpoint,
          truth.drive,
          truth.hysteresis_um,
          truth.position_um,
          truth.measured_um};
}

StreamGreeting stream_greeting(const config::Config& config) {
  StreamGreeting greeting{.stream = "controller",
                          .rate_Hz = config.controller.rate_Hz,
                          .states = words_of("state"),
                          .faults = words_of("fault"),
                          .limits = words_of("limits")};
  for (const controller::CycleColumn* column : columns())
    greeting.columns.push_back({std::string(column->name), std::string(column->unit)});
  for (const config::AxisConfig& axis : config.axes)
    greeting.axes.push_back(
        {axis.wire.name, axis.wire.drive_unit, controller::settling_tolerance_um(axis.control)});
  return greeting;
}

StreamGreeting stream_greeting(const config::Config& config, const twin::Config& twin) {
  StreamGreeting greeting{.stream = "twin", .rate_Hz = config.controller.rate_Hz};
  for (const auto& [name, unit] : truth_columns)
    greeting.columns.push_back({std::string(name), std::string(unit)});
  for (const twin::WiredAxisConfig& axis : twin.axes) {
    const auto same = [&](const config::AxisConfig& of) { return of.wire.name == axis.wire.name; };
    greeting.axes.push_back({axis.wire.name, std::ranges::find_if(config.axes, same)->wire.drive_unit});
  }
  return greeting;
}

}  // namespace hystcan::app
