// Checks one axis only by its frames on the wire, as a node that never sends, because these frames move the
// stage, whatever the state of the controller is. u is the drive in a command, u_last that in the previous
// enabled command; the times `settle`, `off_within`, `grace` and `jitter` are in WireMonitor::Config.
//
//   AmpCommand, enabled        drive_min <= u <= drive_max
//                              |u - u_last| <= slew (dt + jitter) + one LSB,
//                              dt: time between the SYNCs that the two commands name
//                              the first command differs from the amplifier's output by at most such a step
//                              no such command after a fault until the fault is cleared
//   AmpCommand, not enabled    u = safe_drive
//   AmpStatus                  output within the amplifier's own range
//                              output at the safe value `settle` after the amplifier is switched off
//                              not enabled `off_within` after the last enabled command
//
// The monitor detects a fault from ControllerStatus or report_fault(), and its clearing only from
// report_clear(). A command that is already queued when the fault is decided may still pass within `grace`.
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
    double tolerance = 1e-3;     ///< tolerance of an output at the safe value
    can::Duration settle{};      ///< time for slew and lag of the amplifier over its whole range
    can::Duration off_within{};  ///< watchdog time of the amplifier plus a cycle
    can::Duration grace{};       ///< time in which a queued command may pass: a cycle plus a frame
    can::Duration jitter{};      ///< jitter of a SYNC, which may wait for a frame on the wire
  };

  WireMonitor(const Config& config, const can::Database& database);

  void receive(const can::Frame& frame, can::Time when);
  void report_fault(can::Time when);
  void report_clear();

  std::uint64_t commands() const { return commands_; }
  std::uint64_t statuses() const { return statuses_; }
  std::uint64_t count(Violation violation) const { return counts_[static_cast<std::size_t>(violation)]; }
  std::uint64_t violations() const;
  /// Returns descriptions of the first few violations.
  const std::vector<std::string>& found() const { return found_; }
  /// Returns the beginning of the latest sequence of commands that are not enabled.
  can::Time safe_since() const { return safe_since_; }
  bool commands_are_safe() const { return !enabled_; }
  /// Returns the largest step between two enabled commands, relative to the allowed step.
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
  std::optional<can::Decoder<can::ControllerStatus>> decode_report_;  ///< empty: the database has no message
                                                                      ///< ControllerStatus
  std::array<can::Time, can::sync_counter_max + 1U> syncs_{};
  bool enabled_ = false;         ///< state in the last command
  double last_drive_ = 0.0;      ///< drive of the last enabled command
  can::Time last_taken_{};       ///< time of the SYNC that the last enabled command named
  can::Time last_enabled_at_{};  ///< time of the last enabled command on the wire
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
