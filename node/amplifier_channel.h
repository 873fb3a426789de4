// The amplifier of one axis, a channel of an amplifier node: its state, its watchdog and its output relay.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "node/amplifier_node.h"
#include "node/drive_output.h"

namespace hystcan::node {

/// The amplifier of one axis. The amplifier drives its output only while its node is operational and the
/// amplifier is enabled and receives commands. The amplifier trips (enters the state fault) if no command
/// arrives for `command_timeout`. The fault is latched until a command clears the fault. After the clearing,
/// the output has the safe value and the amplifier is not enabled. When the node leaves the NMT state
/// operational, and at shut_down(), the output moves to the safe value, whatever the watchdog action is.
class AmplifierChannel {
 public:
  AmplifierChannel(const can::AxisWire& wire, const AmplifierConfig& config, const CommonConfig& common,
                   const can::Database& database, can::Scheduler& scheduler, AmplifierNode& node,
                   DriveOutput& output);
  AmplifierChannel(const AmplifierChannel&) = delete;
  AmplifierChannel& operator=(const AmplifierChannel&) = delete;

  AmplifierNode& node() const { return node_; }
  std::size_t index() const { return index_; }  ///< index among the channels of the node
  can::AmpState state() const { return state_; }
  std::uint8_t fault() const { return fault_; }
  /// Returns the last commanded setpoint, also while the amplifier does not drive its output.
  double setpoint() const { return setpoint_; }

  /// Begins a fault whose cause is within the amplifier, such as its temperature. No command can clear this
  /// fault before end_internal_fault().
  void begin_internal_fault();
  void end_internal_fault() { has_internal_cause_ = false; }
  /// Simulates an interlock that opens the relay at the output: disables the amplifier. The amplifier ignores
  /// the command Enable until release_relay().
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
  /// Time in which the output moves in a straight line to the setpoint after each SYNC. Zero: the output gets
  /// the setpoint immediately.
  can::Duration interpolation_;
  can::Scheduler& scheduler_;
  AmplifierNode& node_;
  std::size_t index_;
  DriveOutput& output_;
  can::Layout<can::AmpCommand> command_;
  std::optional<can::Layout<can::AmpStatus>> status_;  ///< signals of the status message; empty: the axis
                                                       ///< has no status message
  std::uint8_t largest_fault_;     ///< maximum of the fault signal in the status; a larger
                                   ///< fault is sent as this maximum
  bool commands_name_their_sync_;  ///< true if commands have a SYNC counter; else, the
                                   ///< amplifier cannot detect stale commands
  std::unique_ptr<can::Timer> watchdog_;
  std::unique_ptr<can::Timer> relay_;  ///< expires when the relay has connected the output
  can::Time relay_closes_at_{};        ///< time at which the relay will have connected the output;
                                       ///< valid while is_enabling_ is true, before the soft start
  std::optional<can::Time> soft_start_begun_;
  double soft_start_from_ = 0.0;
  can::Time command_deadline_{};
  double setpoint_ = 0.0;  ///< last commanded setpoint; AmplifierConfig::apply decides when it takes effect
  unsigned syncs_since_status_ = 0;
  can::AmpState state_ = can::AmpState::off;
  std::uint8_t fault_ = 0;
  bool status_is_due_ = false;
  bool is_enabling_ = false;
  bool has_internal_cause_ = false;
  bool output_works_ = true;
  bool relay_is_open_ = false;  ///< true between open_relay() and release_relay(): Enable is then ignored
};

}  // namespace hystcan::node
