// The amplifier as a node on the bus: follows NMT and AmpCommand, detects when commands stop, sends status.
#pragma once

#include <memory>
#include <optional>

#include "can/bus.h"
#include "can/protocol/node.h"
#include "can/protocol/protocol.h"
#include "twin/config.h"

namespace hystcan::twin {

/// Bit of AmpStatus.Fault beside can::amp_fault: a cause within the amplifier, such as its temperature.
inline constexpr std::uint8_t internal_fault = 0x80;

/// Drives its plant only while it is operational, enabled and receives commands. It trips when no command
/// comes for `command_timeout`. The fault is latched until a command clears it; the output is then at the
/// safe value. A command that clears does not enable. NMT and shut_down() also set the safe value, whatever
/// the watchdog action.
class AmplifierNode {
 public:
  AmplifierNode(const WiredAxisConfig& config, const CommonConfig& common, const can::Database& database,
                can::Scheduler& scheduler, const can::Attach& attach, Plant& plant);

  void start() { nmt_.start(); }
  /// Another node on the bus has the same number: this node is off and silent.
  bool is_taken() const { return nmt_.is_taken(); }
  /// Switches off: the output goes to the safe value, and a last status reports it.
  void shut_down();

  can::AmpState state() const { return state_; }
  std::uint8_t fault() const { return fault_; }
  /// The last commanded setpoint, also while the amplifier does not drive.
  double setpoint() const { return setpoint_; }
  const can::SdoServer& objects() const { return sdo_; }
  const can::E2eChecker& checker() const { return decode_command_.checker(); }
  const can::Bus& bus() const { return *bus_; }
  bool is_on_the_bus() const { return !nmt_.is_silent(); }

  /// Trips for a cause within the amplifier; the fault cannot be cleared before the cause ends.
  void begin_internal_fault();
  void end_internal_fault() { has_internal_cause_ = false; }
  /// The supply fails: the output falls to its safe value. The caller discards the frames of the node.
  void lose_power() { enter(can::AmpState::off); }
  /// The supply returns: the node starts as at its first start. No effect before the first start.
  void restart();

 private:
  void handle(const can::Frame& frame, can::Time received);
  void on_sync(std::uint8_t counter, can::Time received);
  void on_command(const can::AmpCommand& command);
  void on_nmt(can::NmtState state);
  bool is_stale(const can::AmpCommand& command) const;
  void clear_fault();
  void begin_to_enable();
  void connect();
  void start_softly(can::Time now);
  void begin_to_drive();
  void take_setpoint();
  void aim_at(double drive);
  void check_watchdog();
  void trip(std::uint8_t fault, std::uint16_t emergency_code, WatchdogAction action = WatchdogAction::safe);
  void enter(can::AmpState state, WatchdogAction action = WatchdogAction::safe);
  void leave_drive(WatchdogAction action);
  void send_status();
  void boot_up();

  AxisConfig config_;
  /// From one SYNC to the next: the output's target moves in a straight line to a setpoint in this time.
  /// Zero: it is there at once.
  can::Duration interpolation_;
  can::Scheduler& scheduler_;
  can::Decoder<can::AmpCommand> decode_command_;
  std::unique_ptr<can::Bus> bus_;
  Plant& plant_;
  can::NmtSlave nmt_;
  can::SdoServer sdo_;
  std::uint8_t node_;
  bool commands_name_their_sync_;                              ///< false: a command is never stale
  std::optional<can::Encoder<can::AmpStatus>> encode_status_;  ///< empty: the node sends no status
  std::unique_ptr<can::Timer> watchdog_;
  std::unique_ptr<can::Timer> relay_;  ///< expires when the output is connected
  std::optional<can::Time> soft_start_begun_;
  double soft_start_from_ = 0.0;
  can::Time command_deadline_{};
  double setpoint_ = 0.0;  ///< in force now or from the next SYNC on
  unsigned syncs_since_status_ = 0;
  can::AmpState state_ = can::AmpState::off;
  std::uint8_t fault_ = 0;
  std::uint8_t last_sync_ = 0;
  bool is_enabling_ = false;
  bool has_internal_cause_ = false;
  std::optional<can::Encoder<can::AmpStatus>> encode_status_at_power_on_;
};

}  // namespace hystcan::twin
