// Logs the events of a live run: changes of state, what an axis waits for, node events, and the report about
// the bus at the end.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/live/report.h"
#include "can/bus_health_log.h"
#include "config/schema/config.h"
#include "controller/controller.h"
#include "controller/cycle_record.h"

namespace hystcan::app {

/// Returns a function that writes lines to the program's log.
can::BusHealthLog::Sink bus_log_sink();

/// Logs node events: emergencies, and reasons why a node could not be set up.
///
/// A node may send an emergency in every cycle, which would flood the log. The first event of a kind is
/// logged at once. Further events of this kind are counted and logged in one line per second. Two events are
/// of the same kind if axis, node and code are equal.
class EventLog {
 public:
  static constexpr std::size_t most_kinds = 100;

  explicit EventLog(can::BusHealthLog::Sink sink) : sink_(std::move(sink)) {}
  /// Counts the event in `record`, if it has one, and then calls log_pending(). `axes`: names of the axes
  /// that the event concerns.
  void add(const std::string& axes, const controller::CycleRecord& record);
  /// Logs one line for each kind of event that add() counted but did not log yet. Skips a kind that was
  /// logged less than one second before `time_s`. Call this function for each record that is not passed to
  /// add(), so that the counted events are logged although no new event occurs.
  void log_pending(double time_s);

  /// Returns one line for each kind of event, with the total number of its events.
  std::vector<std::string> lines() const;
  /// Returns the number of events that have no line, because the log already had `most_kinds` other kinds.
  std::uint64_t truncated() const { return truncated_; }

 private:
  struct Kind {
    std::string axes;
    std::size_t axis_index = 0;     ///< index of the axis whose record contained the event
    controller::NodeEvent event{};  ///< first event of this kind
    double first_s = 0.0;
    double last_s = 0.0;
    double line_s = 0.0;  ///< time at which this kind was last logged
    std::uint64_t total = 0;
    std::uint64_t pending = 0;  ///< events that are not logged yet
  };
  void count(Kind& kind, const controller::CycleRecord& record);

  can::BusHealthLog::Sink sink_;
  std::vector<Kind> kinds_;
  std::uint64_t truncated_ = 0;
};

BusClosing closing_of(const controller::Controller& controller, const EventLog& events);

class StateLog {
 public:
  StateLog(const config::Config& config, can::BusHealthLog::Sink sink);
  void add(const controller::CycleRecord& record);
  const EventLog& events() const { return events_; }
  bool has_tracked(std::size_t axis) const { return axes_[axis].has_tracked; }
  bool has_any_tracked() const {
    return std::ranges::any_of(axes_, [](const Axis& axis) { return axis.has_tracked; });
  }
  /// Returns a text with everything that prevented the axis from tracking: "x waited for a heartbeat of the
  /// sensor".
  std::string blocks_of(std::size_t axis) const;

 private:
  struct Axis {
    std::string name;
    std::uint8_t amplifier_node = 0;
    std::uint8_t sensor_node = 0;
    double drive_min = 0.0;
    double drive_max = 0.0;
    std::string drive_unit;
    controller::AxisState state = controller::AxisState::offline;
    controller::ArmingBlocks blocks{};
    controller::ArmingBlocks last_blocks{};  ///< newest value of `blocks` that was not empty
    double blocked_since_s = 0.0;            ///< start of the wait for the first condition in `blocks`
    double amplifier_output = 0.0;
    bool block_is_logged = false;
    bool has_tracked = false;

    bool has(std::uint8_t node) const { return node == amplifier_node || node == sensor_node; }
  };
  /// Returns true if the record of another axis already reported this event. A CAN frame that concerns
  /// several axes is in the record of each of them.
  bool is_told_by_another(const controller::CycleRecord& record);
  std::string concerned(const Axis& axis, const controller::NodeEvent& event) const;
  void add_state(Axis& axis, const controller::CycleRecord& record);
  void add_block(Axis& axis, const controller::CycleRecord& record);
  void add_missing_axes();
  /// Returns a text with all conditions in `blocks`, for which the axis waits before it tracks.
  std::string blocks_text(const Axis& axis, controller::ArmingBlocks blocks) const;
  /// Returns the text for one condition for which the axis waits: the node, the value or the axes that do not
  /// meet the condition yet.
  std::string block_text(const Axis& axis, controller::ArmingBlock block) const;

  can::BusHealthLog::Sink sink_;
  std::vector<Axis> axes_;
  EventLog events_;
  struct Told {
    std::size_t axis = 0;
    controller::ForeignFrame frame{};
    double time_s = 0.0;
  };
  std::optional<Told> foreign_;  ///< newest logged frame from a second controller
};

}  // namespace hystcan::app
