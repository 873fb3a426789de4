// Logs the events of a live run's axes: states, what an axis waits for, events of nodes, and the report of
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

/// Returns a sink that writes to the log of the program.
can::BusHealthLog::Sink bus_log_sink();

/// The events of the nodes: emergencies, and reasons why a node could not be set up.
///
/// A node may send an emergency in every cycle. The first one is logged at once. Those that follow within a
/// second are counted and share one line per second. Events are of the same kind if axis, node and code are
/// equal.
class EventLog {
 public:
  static constexpr std::size_t most_kinds = 100;

  explicit EventLog(can::BusHealthLog::Sink sink) : sink_(std::move(sink)) {}
  /// Counts the event of a record, if it has one, and logs the counted events that are due. `axes`: names of
  /// the axes that the event concerns.
  void add(const std::string& axes, const controller::CycleRecord& record);
  /// Logs the counted events that are due. Call this for a record that is not passed to add().
  void log_pending(double time_s);

  /// Returns one line for each kind, with its total.
  std::vector<std::string> lines() const;
  /// Number of events of kinds beyond `most_kinds`. They have no line.
  std::uint64_t truncated() const { return truncated_; }

 private:
  struct Kind {
    std::string axes;
    std::size_t axis_index = 0;     ///< index of the axis whose record contained the event
    controller::NodeEvent event{};  ///< the first event
    double first_s = 0.0;
    double last_s = 0.0;
    double line_s = 0.0;  ///< time of the last line
    std::uint64_t total = 0;
    std::uint64_t pending = 0;  ///< events since the last line
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
  /// Returns what prevented an axis from tracking: "x waited for a heartbeat of the sensor".
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
    controller::ArmingBlocks last_blocks{};  ///< the last blocks that were not empty
    double blocked_since_s = 0.0;            ///< start of the wait for the first of `blocks`
    double amplifier_output = 0.0;
    bool block_is_logged = false;
    bool has_tracked = false;

    bool has(std::uint8_t node) const { return node == amplifier_node || node == sensor_node; }
  };
  /// Returns true if another axis already reported the frame: a frame that concerns several axes is in a
  /// record of each.
  bool is_told_by_another(const controller::CycleRecord& record);
  std::string concerned(const Axis& axis, const controller::NodeEvent& event) const;
  void add_state(Axis& axis, const controller::CycleRecord& record);
  void add_block(Axis& axis, const controller::CycleRecord& record);
  void add_missing_axes();
  /// Returns everything that the axis waits for.
  std::string blocks_text(const Axis& axis, controller::ArmingBlocks blocks) const;
  /// Returns one thing that the axis waits for, with the node, value or axes concerned.
  std::string block_text(const Axis& axis, controller::ArmingBlock block) const;

  can::BusHealthLog::Sink sink_;
  std::vector<Axis> axes_;
  EventLog events_;
  struct Told {
    std::size_t axis = 0;
    controller::ForeignFrame frame{};
    double time_s = 0.0;
  };
  std::optional<Told> foreign_;  ///< the latest reported frame of another controller
};

}  // namespace hystcan::app
