// Watches one axis from the wire alone, as a node that never sends: whatever the controller thinks of itself,
// these frames are what the stage gets.
//
//   AmpCommand   enabled: drive_min <= u <= drive_max;  |u - u_last| <= slew (dt + jitter) + one LSB, dt
//   between
//                the SYNCs that the two commands name; the first one no further than that from where the
//                amplifier is. Not enabled: u = safe_drive. After a fault none is enabled until it is cleared
//   AmpStatus    output within the amplifier's own range; at the safe value `settle` after it was switched
//                off; not enabled `obeys` after the last enabled command
//
// A fault is known from ControllerStatus, or told by faulted(); that it was cleared is told by cleared()
// alone. A command already on its way when the fault was decided has `grace` to pass.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "can/protocol/protocol.h"
#include "controller/control/gate.h"

namespace hystcan::support {

enum class Violation : std::uint8_t {
  drive_out_of_range,
  drive_too_fast,
  starts_elsewhere,
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
    double output_min = 0.0;  ///< of the amplifier itself, drive units
    double output_max = 0.0;
    double tolerance = 1e-3;  ///< of an output at its safe value
    can::Duration settle{};   ///< slew and lag of the amplifier over its whole range
    can::Duration obeys{};    ///< its watchdog, and a cycle
    can::Duration grace{};    ///< a cycle and a frame
    can::Duration jitter{};   ///< of a SYNC on the wire: the frame that was on it
  };

  WireMonitor(const Config& config, const can::Database& database);

  void hear(const can::Frame& frame, can::Time when);
  void faulted(can::Time when);
  void cleared();

  std::uint64_t commands() const { return commands_; }
  std::uint64_t statuses() const { return statuses_; }
  std::uint64_t count(Violation violation) const { return counts_[static_cast<std::size_t>(violation)]; }
  std::uint64_t violations() const;
  /// The first few, in words.
  const std::vector<std::string>& found() const { return found_; }
  /// When the latest run of commands that are not enabled began.
  can::Time safe_since() const { return safe_since_; }
  bool commands_are_safe() const { return !enabled_; }
  /// The largest step between two enabled commands, as a part of what was allowed.
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
  can::Decoder<can::ControllerStatus> decode_report_;
  std::array<can::Time, can::sync_counter_max + 1U> syncs_{};
  bool enabled_ = false;         ///< the last command
  double last_drive_ = 0.0;      ///< of the last enabled one
  can::Time last_taken_{};       ///< the SYNC it named
  can::Time last_enabled_at_{};  ///< its own time on the wire
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
