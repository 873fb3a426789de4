#include "app/live/truth_samples.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace hystcan::app {

TruthSample sample_of(const twin::Truth& truth, can::Time started) {
  return {static_cast<double>(truth.sync_counter),
          can::seconds(truth.time - started),
          static_cast<double>(truth.axis),
          truth.setpoint,
          truth.drive,
          truth.hysteresis_um,
          truth.position_um,
          truth.measured_um};
}

nlohmann::json stream_greeting(const config::Config& config, const twin::Config& twin) {
  nlohmann::json greeting{{"stream", "twin"},
                          {"version", 1},
                          {"rate_Hz", config.controller.rate_Hz},
                          {"columns", nlohmann::json::array()},
                          {"axes", nlohmann::json::array()}};
  for (const SampleColumn& column : truth_columns)
    greeting["columns"].push_back({{"name", column.name}, {"unit", column.unit}});
  for (const twin::WiredAxisConfig& axis : twin.axes) {
    const auto same = [&](const config::AxisConfig& of) { return of.wire.name == axis.wire.name; };
    greeting["axes"].push_back(
        {{"name", axis.wire.name}, {"drive_unit", std::ranges::find_if(config.axes, same)->wire.drive_unit}});
  }
  return greeting;
}

}  // namespace hystcan::app
