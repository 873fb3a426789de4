// What happens to the axes of a live run, as lines of the log: states, what an axis waits for, events of nodes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/live/event_log.h"
#include "can/bus_health_log.h"
#include "config/schema/config.h"
#include "controller/cycle_record.h"

namespace hystcan::app {

class StateLog {
 public:
  StateLog(const config::Config& config, can::BusHealthLog::Sink sink);
  void add(const controller::CycleRecord& record);
  const EventLog& events() const { return events_; }
  /// Some axis has tracked.
  bool has_tracked() const { return has_tracked_; }
  /// What kept the first axis from tracking: "x waited for a heartbeat of the sensor".
  std::string blocks_of_first_axis() const;

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
    controller::ArmingBlocks last_blocks{};  ///< not empty
    double blocked_since_s = 0.0;            ///< the first of them
    double amplifier_output = 0.0;
    bool block_is_logged = false;
  };
  void add_state(Axis& axis, const controller::CycleRecord& record);
  void add_block(Axis& axis, const controller::CycleRecord& record);
  void add_missing_axes();
  /// All that the axis waits for.
  std::string blocks_text(const Axis& axis, controller::ArmingBlocks blocks) const;
  /// What the axis waits for, with the node, the value or the axes that it is about.
  std::string block_text(const Axis& axis, controller::ArmingBlock block) const;

  can::BusHealthLog::Sink sink_;
  std::vector<Axis> axes_;
  EventLog events_;
  bool has_tracked_ = false;
};

}  // namespace hystcan::app
