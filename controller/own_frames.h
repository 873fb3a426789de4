// The controller's own frames of one axis, where the database has them: ControllerStatus and ScanMarker out,
// Setpoint in.
//
//   ControllerStatus   with each heartbeat, and when state or cause have changed
//   ScanMarker         at the beginning of each line of a raster, where the configuration asks for it
//   Setpoint           applied where the configuration allows it; refused ones are counted by their reason
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "can/bus.h"
#include "can/protocol/protocol.h"
#include "controller/control/axis.h"

namespace hystcan::controller {

/// The status of the axis. The following error is limited to the width of the plausible positions.
can::ControllerStatus status_of(const Axis& axis);

/// Sends the status and decides when.
class StatusSender {
 public:
  StatusSender(const can::Database& database, const can::AxisWire& wire);

  /// Identifier of the status. Empty if the database has no such message; then none is ever due.
  std::optional<std::uint32_t> id() const;
  /// Call it with each heartbeat.
  void make_due() { due_ = true; }
  bool is_due(const Axis& axis) const;
  /// False if the bus refused the frame, which then stays due.
  bool send(const Axis& axis, can::Bus& bus);
  /// True for a valid status frame on the bus: it comes from another controller.
  bool is_sound(const can::Frame& frame) { return foreign_ && !foreign_->check(frame); }

 private:
  std::optional<can::Encoder<can::ControllerStatus>> encode_;
  std::optional<can::E2eChecker> foreign_;
  bool due_ = false;
  AxisState sent_state_ = AxisState::offline;
  Cause sent_cause_ = Cause::none;
};

/// Sends a marker for each line of a scan.
class ScanMarkerSender {
 public:
  /// Throws std::invalid_argument where the database has no such message.
  ScanMarkerSender(const can::Database& database, const can::AxisWire& wire);

  /// Once for each step of the axis. A line that begins becomes due, in the place of one that was not sent.
  void note(const AxisReport& report, std::uint8_t sync_counter);
  bool is_due() const { return due_.has_value(); }
  /// False if the bus refused the frame, which then stays due.
  bool send(can::Bus& bus);

 private:
  can::Encoder<can::ScanMarker> encode_;
  std::optional<ScanPlace> place_;  ///< in the last step
  std::optional<can::ScanMarker> due_;
};

/// Counts the live setpoints whose frames were valid.
struct SetpointCounters {
  std::uint64_t taken = 0;
  std::uint64_t not_tracking = 0;
  std::uint64_t out_of_range = 0;
  std::uint64_t unknown_mode = 0;

  std::uint64_t refused() const { return not_tracking + out_of_range + unknown_mode; }
};
/// "2 live setpoints taken, refused: 1 not tracking, 3 out of range"; empty if none has come.
std::string describe(const SetpointCounters& counters);

/// Receives the live setpoints of one axis.
class SetpointReceiver {
 public:
  /// Throws std::invalid_argument where the database has no such message.
  SetpointReceiver(const can::Database& database, const can::AxisWire& wire);

  void on_frame(const can::Frame& frame, Axis& axis);
  std::uint32_t id() const { return decode_.id(); }
  const can::E2eChecker& checker() const { return decode_.checker(); }
  const SetpointCounters& counters() const { return counters_; }

 private:
  can::Decoder<can::Setpoint> decode_;
  SetpointCounters counters_;
};

}  // namespace hystcan::controller
