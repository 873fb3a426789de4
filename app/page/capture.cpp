#include "app/page/capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "app/live/command_handler.h"
#include "base/error.h"
#include "metrics/step_response.h"

namespace hystcan::app {
namespace {

using nlohmann::json;

constexpr double longest_s = 10.0;
constexpr double time_resolution_s = 1e-9;
constexpr double shortest_rest_s = 0.2;  // between two captures of one trigger
constexpr auto occasions = std::to_array<std::string_view>({"step", "level", "fault", "line", "now"});
constexpr auto edges = std::to_array<std::string_view>({"rising", "falling", "either"});

template <std::size_t n>
std::size_t index_in(const std::array<std::string_view, n>& words, const std::string& word, const char* key) {
  const auto found = std::ranges::find(words, word);
  if (found == words.end())
    throw Error(fmt::format("{} is \"{}\", expected one of {}", key, word, fmt::join(words, ", ")));
  return static_cast<std::size_t>(found - words.begin());
}

std::size_t column_of(const json& greeting, const std::string& name) {
  const json& columns = greeting.at("columns");
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (columns[i].at("name") == name) return i;
  throw Error(fmt::format("the stream has no column \"{}\"", name));
}

double seconds_of(const json& request, const char* key) {
  const double time_s = number_of(request, key);
  if (!(time_s >= 0.0 && time_s <= longest_s))
    throw Error(fmt::format("{} is {}, expected 0 to {}", key, time_s, longest_s));
  return time_s;
}

}  // namespace

CycleColumns CycleColumns::of(const json& greeting) {
  return {.count = greeting.at("columns").size(),
          .time = column_of(greeting, "time_s"),
          .axis = column_of(greeting, "axis"),
          .state = column_of(greeting, "state"),
          .fault = column_of(greeting, "fault"),
          .reference = column_of(greeting, "reference_um"),
          .position = column_of(greeting, "position_um"),
          .missing = column_of(greeting, "sample_missing"),
          .line = column_of(greeting, "scan_line"),
          .turnaround = column_of(greeting, "turnaround_us"),
          .lateness = column_of(greeting, "lateness_us")};
}

Trigger Trigger::of(const json& request, const json& greeting) {
  Trigger trigger;
  trigger.name = text_of(request, "on");
  trigger.on = static_cast<On>(index_in(occasions, trigger.name, "on"));
  const double axis = number_of(request, "axis");
  if (!(axis >= 0.0 && axis < static_cast<double>(greeting.at("axes").size()) && axis == std::floor(axis)))
    throw Error(fmt::format("axis is {}, expected the number of one from 0", axis));
  trigger.axis = static_cast<std::size_t>(axis);
  trigger.pre_s = seconds_of(request, "pre_s");
  trigger.post_s = seconds_of(request, "post_s");
  if (trigger.pre_s + trigger.post_s > longest_s)
    throw Error(
        fmt::format("pre_s + post_s is {}, expected at most {}", trigger.pre_s + trigger.post_s, longest_s));
  if (request.contains("repeat")) trigger.repeat = request.at("repeat") == true;
  if (trigger.on == On::step || trigger.on == On::level) trigger.level = number_of(request, "level");
  if (trigger.on == On::level) {
    trigger.signal = column_of(greeting, text_of(request, "signal"));
    if (request.contains("edge"))
      trigger.edge = static_cast<Edge>(index_in(edges, text_of(request, "edge"), "edge"));
  }
  return trigger;
}

json step_of(const Capture& capture, const CycleColumns& at, double tolerance_um) {
  const std::size_t rows = capture.rows.size() / at.count;
  const auto column = [&](std::size_t which) {
    std::vector<double> values(rows);
    for (std::size_t row = 0; row < rows; ++row) values[row] = capture.rows[row * at.count + which];
    return values;
  };
  const std::vector<double> time_s = column(at.time), reference_um = column(at.reference),
                            missing = column(at.missing);
  std::vector<double> position_um = column(at.position);
  for (std::size_t row = 0; row < rows; ++row)  // the controller has not had these samples
    if (missing[row] != 0.0) position_um[row] = std::numeric_limits<double>::quiet_NaN();
  const auto step = metrics::step_at({time_s, reference_um, position_um}, capture.trigger_row, tolerance_um);
  if (!step) return nullptr;
  const auto rest = std::span(position_um).subspan(capture.trigger_row, step->cycles);
  double sum_um = 0.0, samples = 0.0;
  for (const double position : rest.last(std::max<std::size_t>(rest.size() / 5, 1))) {
    if (!std::isfinite(position)) continue;
    sum_um += position;
    ++samples;
  }
  const auto or_null = [](const std::optional<double>& time) { return time ? json(*time) : json(); };
  return {{"from_um", step->from_um},
          {"to_um", step->to_um},
          {"band_um", step->band_um},
          {"overshoot_percent", 100.0 * step->overshoot()},
          {"rise_s", or_null(step->rise_s())},
          {"settling_s", or_null(step->settling_s())},
          {"steady_error_um", step->to_um - sum_um / samples},
          {"judged_s", step->last_s - step->begin_s}};
}

bool CaptureTrigger::fires(std::span<const double> row) const {
  if (trigger_.on == Trigger::On::now) return true;
  if (before_.empty()) return false;
  const auto was = [&](std::size_t column) { return before_[column]; };
  switch (trigger_.on) {
    case Trigger::On::step:
      return std::abs(row[at_.reference] - was(at_.reference)) > trigger_.level;
    case Trigger::On::fault:
      return row[at_.fault] != was(at_.fault) && row[at_.fault] != 0.0;
    case Trigger::On::line:
      return std::isfinite(row[at_.line]) && row[at_.line] != was(at_.line);
    default:
      break;
  }
  const double from = was(trigger_.signal), to = row[trigger_.signal];
  const bool rises = from < trigger_.level && to >= trigger_.level;
  const bool falls = from > trigger_.level && to <= trigger_.level;
  return (rises && trigger_.edge != Trigger::Edge::falling) ||
         (falls && trigger_.edge != Trigger::Edge::rising);
}

std::optional<Capture> CaptureTrigger::put(std::span<const double> row, const RowHistory& history) {
  if (row[at_.axis] != static_cast<double>(trigger_.axis)) return std::nullopt;
  if (!fired_s_ && row[at_.time] >= rests_until_s_ && fires(row)) fired_s_ = row[at_.time];
  before_.assign(row.begin(), row.end());
  if (!fired_s_ || row[at_.time] < *fired_s_ + trigger_.post_s - time_resolution_s) return std::nullopt;
  Capture capture = collect(history);
  fired_s_.reset();
  rests_until_s_ = row[at_.time] + std::max(trigger_.pre_s, shortest_rest_s);
  return capture;
}

Capture CaptureTrigger::collect(const RowHistory& history) const {
  Capture capture{.rows = {}, .trigger_time_s = *fired_s_};
  for (std::uint64_t i = history.first(); i < history.end(); ++i) {
    const std::span<const double> row = history.row(i);
    const double time_s = row[at_.time];
    if (row[at_.axis] != static_cast<double>(trigger_.axis) ||
        time_s < *fired_s_ - trigger_.pre_s - time_resolution_s)
      continue;
    if (time_s < *fired_s_) ++capture.trigger_row;
    capture.rows.insert(capture.rows.end(), row.begin(), row.end());
  }
  return capture;
}

}  // namespace hystcan::app
