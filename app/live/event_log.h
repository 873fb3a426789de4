// The events of the nodes as lines of the log: emergencies, and reasons why a node could not be set up.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "can/bus_health_log.h"
#include "controller/cycle_record.h"

namespace hystcan::app {

/// A node may send an emergency in every cycle. The first one has a line at once. Those that follow within a second are
/// counted, and have one line per second together. Events are of one kind if axis, node and code agree.
class EventLog {
 public:
  static constexpr std::size_t most_kinds = 100;

  explicit EventLog(can::BusHealthLog::Sink sink) : sink_(std::move(sink)) {}
  /// Takes every record, also one without an event.
  void add(const std::string& axis, const controller::CycleRecord& record);

  /// One line for each kind, with its total.
  std::vector<std::string> lines() const;
  /// The events of kinds beyond `most_kinds`. They have no line.
  std::uint64_t truncated() const { return truncated_; }

 private:
  struct Kind {
    std::string axis;
    std::size_t axis_index = 0;
    controller::NodeEvent event{};  ///< the first one
    double first_s = 0.0;
    double last_s = 0.0;
    double line_s = 0.0;  ///< of the last line
    std::uint64_t total = 0;
    std::uint64_t pending = 0;  ///< since the last line
  };
  void count(Kind& kind, const controller::CycleRecord& record);
  void log_pending(double time_s);

  can::BusHealthLog::Sink sink_;
  std::vector<Kind> kinds_;
  std::uint64_t truncated_ = 0;
};

}  // namespace hystcan::app
