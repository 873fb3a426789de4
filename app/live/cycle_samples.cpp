#include "app/live/cycle_samples.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "controller/cycle_record.h"

namespace hystcan::app {
namespace {

using Columns = std::array<const controller::CycleColumn*, streamed_columns.size()>;

const Columns& columns() {
  static const Columns found = [] {
    Columns all{};
    std::ranges::transform(streamed_columns, all.begin(), controller::find_cycle_column);
    return all;
  }();
  return found;
}

std::vector<std::string> words_of(std::string_view column) {
  return controller::words_of(*controller::find_cycle_column(column));
}

}  // namespace

CycleSample sample_of(const controller::CycleRecord& record) {
  CycleSample sample{};
  std::ranges::transform(columns(), sample.begin(),
                         [&](const controller::CycleColumn* column) { return column->value(record); });
  return sample;
}

nlohmann::json stream_greeting(const config::Config& config) {
  nlohmann::json greeting{{"stream", "controller"},
                          {"version", 1},
                          {"rate_Hz", config.controller.rate_Hz},
                          {"states", words_of("state")},
                          {"faults", words_of("fault")},
                          {"limits", words_of("limits")},
                          {"columns", nlohmann::json::array()},
                          {"axes", nlohmann::json::array()}};
  for (const controller::CycleColumn* column : columns())
    greeting["columns"].push_back({{"name", column->name}, {"unit", column->unit}});
  for (const config::AxisConfig& axis : config.axes)
    greeting["axes"].push_back({{"name", axis.wire.name}, {"drive_unit", axis.wire.drive_unit}});
  return greeting;
}

}  // namespace hystcan::app
