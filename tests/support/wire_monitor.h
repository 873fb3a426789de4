// Checks one axis from the wire alone, as a node that never sends: the stage gets these frames, whatever the
// state of the controller is.
//
//   AmpCommand, enabled        drive_min <= u <= drive_max
//                              |u - u_last| <= slew (dt + jitter) + one LSB,
//                              dt between the SYNCs that the two commands name
//                              the first one is no further than such a step from the amplifier's output
//                              none after a fault until the fault is cleared
//   AmpCommand, not enabled    u = safe_drive
//   AmpStatus                  output within the amplifier's own range
//                              output at the safe value `settle` after the amplifier is switched off
//                              not enabled `off_within` after the last enabled command
//
// The monitor learns of a fault from ControllerStatus or by report_fault(), and of its clearing only by
// report_clear(). A command that is already on its way when the fault is decided has `grace` to pass.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/protocol/protocol.h"
#include "controller/control/gate.h"

namespace hystcan::support {

enum class Violation : std::uint8_t {
  drive_out_of_range,
  drive_too_fast,
  start_not_at_output,
  unsafe_when_not_enabled,
  enabled_while_faulted,
  output_out_of_range,
  output_not_safe,
  not_switched_off,
};
inline constexpr std::size_t violation_count = 8;
std::string_view to_string(Violation violation);

class WireMonitor {
 public:
  struct Config {
    can::AxisWire wire;
    controller::Gate::Config gate;
    double output_min = 0.0;  ///< range of the amplifier itself, in drive units
    double output_max = 0.0;
    double tolerance = 1e-3;     ///< of an output at the safe value
    can::Duration settle{};      ///< slew and lag of the amplifier over its whole range
    can::Duration off_within{};  ///< the amplifier's watchdog time and a cycle
    can::Duration grace{};       ///< a cycle and a frame
    can::Duration jitter{};      ///< of a SYNC, which waits for the frame that is on the wire
  };

  WireMonitor(const Config& config, const can::Database& database);

  void receive(const can::Frame& frame, can::Time when);
  void report_fault(can::Time when);
  void report_clear();

  std::uint64_t commands() const { return commands_; }
  std::uint64_t statuses() const { return statuses_; }
  std::uint64_t count(Violation violation) const { return counts_[static_cast<std::size_t>(violation)]; }
  std::uint64_t violations() const;
  /// Descriptions of the first few violations.
  const std::vector<std::string>& found() const { return found_; }
  /// The begin of the latest run of commands that are not enabled.
  can::Time safe_since() const { return safe_since_; }
  bool commands_are_safe() const { return !enabled_; }
  /// The largest step between two enabled commands, as a part of the allowed one.
  double steepest() const { return steepest_; }

 private:
  void on_command(const can::AmpCommand& command, can::Time when);
  void on_enabled(const can::AmpCommand& command, can::Time when);
  void on_status(const can::AmpStatus& status, can::Time when);
  void judge_step(double setpoint, can::Time taken, can::Time when);
  can::Time time_of_sync(std::uint8_t counter, can::Time when) const;
  void note(Violation violation, can::Time when, double value);

  Config config_;
  can::Decoder<can::AmpCommand> decode_command_;
  can::Decoder<can::AmpStatus> decode_status_;
  std::optional<can::Decoder<can::ControllerStatus>> decode_report_;  ///< empty: the database has none
  std::array<can::Time, can::sync_counter_max + 1U> syncs_{};
  bool enabled_ = false;         ///< of the last command
  double last_drive_ = 0.0;      ///< of the last enabled command
  can::Time last_taken_{};       ///< time of the SYNC that it named
  can::Time last_enabled_at_{};  ///< its time on the wire
  can::Time safe_since_{};
  bool amplifier_enabled_ = false;
  double output_ = 0.0;
  can::Time switched_off_{};
  bool latched_ = false;
  can::Time latched_at_{};
  double steepest_ = 0.0;
  std::uint64_t commands_ = 0;
  std::uint64_t statuses_ = 0;
  std::array<std::uint64_t, violation_count> counts_{};
  std::vector<std::string> found_;
};

}  // namespace hystcan::support
