// The amplifier of one axis: state, watchdog and relay of its node's channel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "node/amplifier_node.h"
#include "node/drive_output.h"

namespace hystcan::node {

/// The amplifier of one axis. It drives its output only while its node is operational and it is enabled and
/// receives commands. It trips when no command comes for `command_timeout`. The fault is latched until a
/// command clears it; the output is then at the safe value. A command that clears does not enable. NMT and
/// shut_down() also set the safe value, whatever the watchdog action.
class AmplifierChannel {
 public:
  AmplifierChannel(const can::AxisWire& wire, const AmplifierConfig& config, const CommonConfig& common,
                   const can::Database& database, can::Scheduler& scheduler, AmplifierNode& node,
                   DriveOutput& output);
  AmplifierChannel(const AmplifierChannel&) = delete;
  AmplifierChannel& operator=(const AmplifierChannel&) = delete;

  AmplifierNode& node() const { return node_; }
  std::size_t index() const { return index_; }  ///< among the channels of the node
  can::AmpState state() const { return state_; }
  std::uint8_t fault() const { return fault_; }
  /// The last commanded setpoint, also while the amplifier does not drive.
  double setpoint() const { return setpoint_; }

  /// Trips for a cause within the amplifier; the fault cannot be cleared before the cause ends.
  void begin_internal_fault();
  void end_internal_fault() { has_internal_cause_ = false; }
  /// Leaves Enable, and obeys none until the relay is released.
  void open_relay();
  void release_relay() { relay_is_open_ = false; }

 private:
  friend class AmplifierNode;
  void on_command(const can::AmpCommand& command, can::Time received);
  void on_sync(can::Time received);
  void on_nmt(can::NmtState state);
  void boot_up();
  void watch_output();
  void clear_fault();
  void begin_to_enable();
  void check_relay();
  void connect();
  void start_softly(can::Time now);
  void begin_to_drive();
  void check_watchdog();
  void trip(std::uint8_t fault, std::uint16_t emergency_code, WatchdogAction action = WatchdogAction::safe);
  void enter(can::AmpState state, WatchdogAction action = WatchdogAction::safe);
  void leave_drive(WatchdogAction action);

  AmplifierConfig config_;
  /// From one SYNC to the next: the output's target moves in a straight line to a setpoint in this time.
  /// Zero: it is there at once.
  can::Duration interpolation_;
  can::Scheduler& scheduler_;
  AmplifierNode& node_;
  std::size_t index_;
  DriveOutput& output_;
  can::Layout<can::AmpCommand> command_;
  std::optional<can::Layout<can::AmpStatus>> status_;  ///< empty: it has no status
  std::uint8_t largest_fault_;                         ///< a larger one is reported as this
  bool commands_name_their_sync_;                      ///< false: a command is never stale
  std::unique_ptr<can::Timer> watchdog_;
  std::unique_ptr<can::Timer> relay_;  ///< expires when the output is connected
  can::Time relay_closes_at_{};        ///< while it is enabling and no soft start has begun
  std::optional<can::Time> soft_start_begun_;
  double soft_start_from_ = 0.0;
  can::Time command_deadline_{};
  double setpoint_ = 0.0;  ///< in force now or from the next SYNC on
  unsigned syncs_since_status_ = 0;
  can::AmpState state_ = can::AmpState::off;
  std::uint8_t fault_ = 0;
  bool status_is_due_ = false;
  bool is_enabling_ = false;
  bool has_internal_cause_ = false;
  bool output_works_ = true;
  bool relay_is_open_ = false;  ///< by a fault
};

}  // namespace hystcan::node
