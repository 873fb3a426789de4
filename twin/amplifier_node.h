// The amplifier as a node on the bus: follows NMT and AmpCommand, detects when commands stop, sends status.
//
// The axes of a node share the command frame; a frame that is accepted commands all of them. They share the
// status message too, or each has its own. Where something happens to several axes at once, it is one
// emergency, and a shared status is sent once.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/protocol/protocol.h"
#include "twin/bus_node.h"
#include "twin/config.h"

namespace hystcan::twin {

/// Bit of AmpStatus.Fault beside can::amp_fault: a cause within the amplifier, such as its temperature.
inline constexpr std::uint8_t internal_fault = 0x80;

class AmplifierChannel;

class AmplifierNode final : public BusNode {
 public:
  /// `first`: the first of its axes.
  AmplifierNode(const can::AxisWire& first, const CommonConfig& common, const can::Database& database,
                can::Scheduler& scheduler, const can::Attach& attach);

  const can::E2eChecker& checker() const { return checker_; }
  const std::vector<AmplifierChannel*>& channels() const { return channels_; }
  void shut_down() override;
  void lose_power() override;

 private:
  friend class AmplifierChannel;
  /// The axes of one status message.
  struct StatusMessage {
    can::E2eProtector protector;
    std::vector<AmplifierChannel*> channels;
  };

  AmplifierNode(const can::Layout<can::AmpCommand>& command, std::uint8_t number, const CommonConfig& common,
                can::Scheduler& scheduler, const can::Attach& attach);
  void add(AmplifierChannel& channel);
  void on_command(const can::Frame& frame, can::Time received);
  void on_sync(std::uint8_t counter, can::Time received);
  void on_nmt(can::NmtState state) override;
  void boot_up();
  /// docs/protocol/nodes.md, "Stale commands".
  bool is_stale(const can::AmpCommand& command, can::Time received) const;
  void check_watchdogs();
  void note_emergency(std::uint16_t code);
  /// Sends the statuses whose time has come; in a slot the oldest one alone.
  void report_regularly();
  /// Sends the emergencies and every status that is due.
  void report();
  void send(StatusMessage& message);

  can::Scheduler& scheduler_;
  can::Duration cycle_;
  std::uint32_t command_id_;
  can::E2eChecker checker_;
  std::vector<AmplifierChannel*> channels_;
  std::vector<StatusMessage> statuses_;
  std::vector<std::uint16_t> emergencies_;  ///< codes, to be sent
  std::uint8_t last_sync_ = 0;
  can::Time last_sync_at_{};
  std::optional<can::Time> former_sync_at_;  ///< of the SYNC before it; empty if that SYNC was not received
};

/// The amplifier of one axis. It drives its plant only while its node is operational and it is enabled and
/// receives commands. It trips when no command comes for `command_timeout`. The fault is latched until a
/// command clears it; the output is then at the safe value. A command that clears does not enable. NMT and
/// shut_down() also set the safe value, whatever the watchdog action.
class AmplifierChannel {
 public:
  AmplifierChannel(const WiredAxisConfig& config, const CommonConfig& common, const can::Database& database,
                   can::Scheduler& scheduler, AmplifierNode& node, Plant& plant);
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

  AxisConfig config_;
  /// From one SYNC to the next: the output's target moves in a straight line to a setpoint in this time.
  /// Zero: it is there at once.
  can::Duration interpolation_;
  can::Scheduler& scheduler_;
  AmplifierNode& node_;
  std::size_t index_;
  Plant& plant_;
  can::Layout<can::AmpCommand> command_;
  std::optional<can::Layout<can::AmpStatus>> status_;  ///< empty: it has no status
  std::uint8_t largest_fault_;                         ///< a larger one is reported as this
  bool commands_name_their_sync_;                      ///< false: a command is never stale
  std::unique_ptr<can::Timer> watchdog_;
  std::unique_ptr<can::Timer> relay_;  ///< expires when the output is connected
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
  bool relay_is_open_ = false;  ///< by a fault
};

}  // namespace hystcan::twin
