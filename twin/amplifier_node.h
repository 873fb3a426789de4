// The amplifier as a node on the bus: obeys NMT and AmpCommand, watches for silence, reports.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string_view>

#include "can/bus.h"
#include "can/protocol/node.h"
#include "can/protocol/protocol.h"
#include "twin/plant.h"

namespace hystcan::twin {

/// What the output does when commands stop, until a command clears the fault.
enum class WatchdogAction : std::uint8_t {
  safe,  ///< goes to the safe value as fast as the amplifier can
  hold,  ///< stays at the last setpoint in force
  ramp,  ///< goes to the safe value at the amplifier's ramp
  off    ///< is not driven: the load discharges to zero
};
constexpr auto words(WatchdogAction) {
  return std::to_array<std::string_view>({"safe", "hold", "ramp", "off"});
}

/// When a setpoint takes effect.
enum class Apply : std::uint8_t {
  sync,    ///< at the next SYNC (a synchronous PDO, CiA 301): one cycle after its own, whatever the bus does
  receipt  ///< as its frame arrives: sooner, and as late as the bus makes it
};
constexpr auto words(Apply) { return std::to_array<std::string_view>({"sync", "receipt"}); }

/// Bit of AmpStatus.Fault beside can::amp_fault: a cause within the amplifier, as of its temperature.
inline constexpr std::uint8_t internal_fault = 0x80;

/// Drives its plant only while operational, enabled and commanded. Commands that stop for `command_timeout`
/// trip it: the fault stays until a command clears it, which leaves the output at the safe value. So do NMT
/// and shut_down(), whatever the watchdog has done.
class AmplifierNode {
 public:
  struct Config {
    can::AxisWire wire;
    double drive_min = 0.0;  ///< setpoints outside trip the amplifier
    double drive_max = 100.0;
    double safe_drive = 0.0;
    can::Duration command_timeout{};
    can::Duration heartbeat_period{};
    unsigned status_every = 10;  ///< SYNCs per AmpStatus
    WatchdogAction watchdog_action = WatchdogAction::safe;
    Apply apply = Apply::sync;
  };

  AmplifierNode(const Config& config, const can::Database& database, can::Scheduler& scheduler,
                const can::Attach& attach, Plant& plant);

  void start() { nmt_.start(); }
  /// Somebody else on the bus is this node: it is off and silent.
  bool is_taken() const { return nmt_.is_taken(); }
  /// Switches off: the output goes to the safe value, and one last status says so.
  void shut_down();

  can::AmpState state() const { return state_; }
  std::uint8_t fault() const { return fault_; }
  /// As last commanded, whether or not it drives.
  double setpoint() const { return setpoint_; }
  std::uint64_t stale_commands() const { return stale_commands_; }
  const can::SdoServer& objects() const { return sdo_; }
  const can::E2eChecker& checker() const { return decode_command_.checker(); }
  const can::Bus& bus() const { return *bus_; }
  bool is_on_the_bus() const { return !nmt_.is_silent(); }

  /// A cause within the amplifier comes: it trips, and is not to be cleared until the cause is gone.
  void begin_internal_fault();
  void end_internal_fault() { has_internal_cause_ = false; }
  /// The supply goes: the output falls to its safe value. What the node says meanwhile is nobody's.
  void lose_power() { enter(can::AmpState::off); }
  /// It comes back, and the node with it as at its first start; nothing where it never started.
  void restart();

 private:
  void handle(const can::Frame& frame, can::Time received);
  void on_sync(std::uint8_t counter, can::Time received);
  void on_command(const can::AmpCommand& command);
  void on_nmt(can::NmtState state);
  void check_watchdog();
  void trip(std::uint8_t fault, std::uint16_t emergency_code, WatchdogAction action = WatchdogAction::safe);
  void enter(can::AmpState state, WatchdogAction action = WatchdogAction::safe);
  void leave_drive(WatchdogAction action);
  void send_status();
  void forget_everything();

  Config config_;
  can::Scheduler& scheduler_;
  can::Decoder<can::AmpCommand> decode_command_;
  std::unique_ptr<can::Bus> bus_;
  Plant& plant_;
  can::NmtSlave nmt_;
  can::SdoServer sdo_;
  bool commands_name_their_sync_;                              ///< else none is ever stale
  std::optional<can::Encoder<can::AmpStatus>> encode_status_;  ///< empty: it reports nothing
  std::unique_ptr<can::Timer> watchdog_;
  can::Time command_deadline_{};
  can::AmpState state_ = can::AmpState::off;
  std::uint8_t fault_ = 0;
  double setpoint_ = 0.0;  ///< in force, or taken over at the next SYNC
  std::uint8_t last_sync_ = 0;
  unsigned syncs_since_status_ = 0;
  std::uint64_t stale_commands_ = 0;
  bool has_internal_cause_ = false;
  std::optional<can::Encoder<can::AmpStatus>> encode_status_at_power_on_;
};

}  // namespace hystcan::twin
