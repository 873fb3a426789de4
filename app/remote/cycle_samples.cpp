#include "app/remote/cycle_samples.h"

#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "controller/control/fault.h"

namespace hystcan::app {
namespace {

double microseconds(can::Duration duration) {
  return std::chrono::duration<double, std::micro>(duration).count();
}

std::vector<std::string> words_of_causes() {
  std::vector<std::string> words;
  for (unsigned i = 0; i < controller::cause_count; ++i)
    words.emplace_back(to_string(static_cast<controller::Cause>(i)));
  return words;
}

std::vector<std::string> words_of_states() {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < controller::axis_state_count; ++i)
    words.emplace_back(to_string(static_cast<controller::AxisState>(i)));
  return words;
}

}  // namespace

nlohmann::json columns_to_json(std::span<const SampleColumn> columns) {
  nlohmann::json named = nlohmann::json::array();
  for (const SampleColumn& column : columns) named.push_back({{"name", column.name}, {"unit", column.unit}});
  return named;
}

CycleSample sample_of(const controller::CycleRecord& record) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const controller::AxisReport& report = record.report;
  const bool tracks = report.state == controller::AxisState::tracking;
  const auto& scan = report.point.scan;
  return {static_cast<double>(record.cycle),
          record.time_s,
          static_cast<double>(record.axis),
          static_cast<double>(report.state),
          static_cast<double>(report.cause),
          static_cast<double>(report.limits),
          report.sample_missing ? 1.0 : 0.0,
          tracks ? static_cast<double>(report.point.segment) : none,
          tracks ? report.point.shape_time_s : none,
          tracks ? report.reference_um : none,
          report.position_um,
          tracks ? report.demand_um : none,
          tracks ? report.learning.correction_um : none,
          report.drive,
          record.amplifier_output,
          microseconds(record.turnaround),
          microseconds(record.phases.lateness),
          scan ? static_cast<double>(scan->line) : none,
          scan && scan->pixel >= 0 ? static_cast<double>(scan->pixel) : none};
}

nlohmann::json stream_greeting(const config::Config& config) {
  nlohmann::json greeting{{"stream", "controller"},
                          {"version", 1},
                          {"rate_Hz", config.controller.rate_Hz},
                          {"states", words_of_states()},
                          {"faults", words_of_causes()},
                          {"limits", {"range", "slew", "not_finite", "model", "not_invertible"}},
                          {"columns", columns_to_json(cycle_columns)},
                          {"axes", nlohmann::json::array()}};
  for (const config::AxisConfig& axis : config.axes)
    greeting["axes"].push_back({{"name", axis.wire.name}, {"drive_unit", axis.wire.drive_unit}});
  return greeting;
}

}  // namespace hystcan::app
