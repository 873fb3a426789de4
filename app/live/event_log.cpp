#include "app/live/event_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hystcan::app {
namespace {

using LogLevel = can::BusHealthLog::Level;
constexpr double between_lines_s = 1.0;

std::string at(const std::string& axis, double time_s, const controller::NodeEvent& event) {
  return fmt::format("{}: at {:.3f} s {}", axis, time_s, describe(event));
}

LogLevel level_of(const controller::NodeEvent& event) {
  return is_all_clear(event) ? LogLevel::info : LogLevel::warning;
}

}  // namespace

void EventLog::add(const std::string& axis, const controller::CycleRecord& record) {
  if (record.event) {
    const auto known = std::ranges::find_if(kinds_, [&](const Kind& kind) {
      return kind.axis_index == record.axis && are_of_one_kind(kind.event, *record.event);
    });
    if (known != kinds_.end()) {
      count(*known, record);
    } else if (kinds_.size() < most_kinds) {
      kinds_.push_back({.axis = axis,
                        .axis_index = record.axis,
                        .event = *record.event,
                        .first_s = record.time_s,
                        .line_s = record.time_s - between_lines_s});
      count(kinds_.back(), record);
    } else if (std::exchange(truncated_, truncated_ + record.event->times) == 0) {
      sink_(LogLevel::warning, fmt::format("{}; more than {} kinds of events: further ones are only counted",
                                           at(axis, record.time_s, *record.event), most_kinds));
    }
  }
  log_pending(record.time_s);
}

void EventLog::count(Kind& kind, const controller::CycleRecord& record) {
  kind.last_s = record.time_s;
  kind.total += record.event->times;
  const bool is_new = kind.pending == 0 && record.time_s - kind.line_s >= between_lines_s;
  kind.pending += record.event->times;
  if (!is_new) return;
  kind.line_s = record.time_s;
  --kind.pending;
  sink_(level_of(kind.event), at(kind.axis, record.time_s, *record.event));
}

void EventLog::log_pending(double time_s) {
  for (Kind& kind : kinds_) {
    if (kind.pending == 0 || time_s - kind.line_s < between_lines_s) continue;
    sink_(level_of(kind.event),
          fmt::format("{}: {}, {} more times in {:.1f} s", kind.axis, describe(kind.event),
                      std::exchange(kind.pending, 0), time_s - kind.line_s));
    kind.line_s = time_s;
  }
}

std::vector<std::string> EventLog::lines() const {
  std::vector<std::string> lines;
  lines.reserve(kinds_.size() + 1);
  for (const Kind& kind : kinds_) {
    lines.push_back(at(kind.axis, kind.first_s, kind.event));
    if (kind.total > 1) lines.back() += fmt::format(", {} times until {:.3f} s", kind.total, kind.last_s);
  }
  return lines;
}

}  // namespace hystcan::app
