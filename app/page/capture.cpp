#include "app/page/capture.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "app/live/control_protocol.h"
#include "base/error.h"
#include "metrics/step_response.h"

namespace hystcan::app {
namespace {

using nlohmann::json;

constexpr double longest_s = 10.0;
constexpr double time_resolution_s = 1e-9;
constexpr double shortest_rest_s = 0.2;  // shortest time between two captures of a trigger
constexpr auto occasions = std::to_array<std::string_view>({"step", "level", "fault", "line", "now"});
constexpr auto edges = std::to_array<std::string_view>({"rising", "falling", "either"});

template <std::size_t n>
std::size_t index_in(const std::array<std::string_view, n>& words, const std::string& word, const char* key) {
  const auto found = std::ranges::find(words, word);
  if (found == words.end())
    throw Error(fmt::format("{} is \"{}\"", key, word), expect("one of {}", fmt::join(words, ", ")));
  return static_cast<std::size_t>(found - words.begin());
}

std::size_t column_of(const StreamGreeting& greeting, const std::string& name) {
  if (const auto column = column_in(greeting, name)) return *column;
  throw Error(fmt::format("the stream has no column \"{}\"", name));
}

double seconds_of(const json& request, const char* key) {
  const double time_s = number_of(request, key);
  if (!(time_s >= 0.0 && time_s <= longest_s))
    throw Error(fmt::format("{} is {}", key, time_s), expect("0 to {}", longest_s));
  return time_s;
}

}  // namespace

CycleColumns CycleColumns::of(const StreamGreeting& greeting) {
  return {.count = greeting.columns.size(),
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

Trigger::Trigger(const json& request, const StreamGreeting& greeting)
    : at_(CycleColumns::of(greeting)),
      name_(text_of(request, "on")),
      on_(static_cast<On>(index_in(occasions, name_, "on"))) {
  const double axis = number_of(request, "axis");
  if (!(axis >= 0.0 && axis < static_cast<double>(greeting.axes.size()) && axis == std::floor(axis)))
    throw Error(fmt::format("axis is {}", axis), expect("the index of an axis, from 0"));
  axis_ = static_cast<std::size_t>(axis);
  pre_s_ = seconds_of(request, "pre_s");
  post_s_ = seconds_of(request, "post_s");
  if (pre_s_ + post_s_ > longest_s)
    throw Error(fmt::format("pre_s + post_s is {}", pre_s_ + post_s_), expect("at most {}", longest_s));
  repeats_ = request.contains("repeat") && request.at("repeat") == true;
  if (on_ == On::step || on_ == On::level) level_ = number_of(request, "level");
  if (on_ != On::level) return;
  signal_ = column_of(greeting, text_of(request, "signal"));
  const std::size_t edge = request.contains("edge") ? index_in(edges, text_of(request, "edge"), "edge") : 2;
  rising_ = edge != 1;
  falling_ = edge != 0;
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
  for (std::size_t row = 0; row < rows; ++row)  // ignores the position if the controller received no sample
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

bool Trigger::fires(std::span<const double> row) const {
  if (on_ == On::now) return true;
  if (before_.empty()) return false;
  const auto was = [&](std::size_t column) { return before_[column]; };
  switch (on_) {
    case On::step:
      return std::abs(row[at_.reference] - was(at_.reference)) > level_;
    case On::fault:
      return row[at_.fault] != was(at_.fault) && row[at_.fault] != 0.0;
    case On::line:
      return std::isfinite(row[at_.line]) && row[at_.line] != was(at_.line);
    default:
      break;
  }
  const double from = was(signal_), to = row[signal_];
  const bool rises = from < level_ && to >= level_;
  const bool falls = from > level_ && to <= level_;
  return (rises && rising_) || (falls && falling_);
}

std::optional<Capture> Trigger::put(std::span<const double> row, const RowHistory& history) {
  if (row[at_.axis] != static_cast<double>(axis_)) return std::nullopt;
  if (!fired_s_ && row[at_.time] >= rests_until_s_ && fires(row)) fired_s_ = row[at_.time];
  before_.assign(row.begin(), row.end());
  if (!fired_s_ || row[at_.time] < *fired_s_ + post_s_ - time_resolution_s) return std::nullopt;
  Capture capture = collect(history);
  fired_s_.reset();
  rests_until_s_ = row[at_.time] + std::max(pre_s_, shortest_rest_s);
  return capture;
}

Capture Trigger::collect(const RowHistory& history) const {
  Capture capture{.rows = {}, .trigger_time_s = *fired_s_};
  for (std::uint64_t i = history.first(); i < history.end(); ++i) {
    const std::span<const double> row = history.row(i);
    const double time_s = row[at_.time];
    if (row[at_.axis] != static_cast<double>(axis_) || time_s < *fired_s_ - pre_s_ - time_resolution_s)
      continue;
    if (time_s < *fired_s_) ++capture.trigger_row;
    capture.rows.insert(capture.rows.end(), row.begin(), row.end());
  }
  return capture;
}

}  // namespace hystcan::app
