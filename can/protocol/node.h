// The CANopen frames between nodes (CiA 301), and the life cycle of a node: boot-up, NMT states, heartbeat.
// The table lists their identifiers. `node` is a node id: SensorSample has the id of the sensor, the other
// messages of an axis have the id of the amplifier. Emergency and heartbeat have the id of their sender, SDO
// has the id of the server.
//
//   NMT                       0x000
//   SYNC                      0x080
//   emergency                 0x080 + node
//   AmpStatus, SensorSample   0x180 + node
//   AmpCommand                0x200 + node
//   ControllerStatus          0x280 + node
//   Setpoint                  0x300 + node
//   ScanMarker                0x380 + node
//   SDO response              0x580 + node
//   SDO request               0x600 + node
//   heartbeat                 0x700 + node
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "can/bus.h"

namespace hystcan::can {

enum class NmtCommand : std::uint8_t {
  start = 1,
  stop = 2,
  enter_pre_operational = 128,
  reset_node = 129,
  reset_communication = 130
};
std::string_view to_string(NmtCommand command);
enum class NmtState : std::uint8_t {
  boot_up = 0x00,
  stopped = 0x04,
  operational = 0x05,
  pre_operational = 0x7F
};

inline constexpr std::uint32_t nmt_id = 0x000;
inline constexpr std::uint32_t sync_id = 0x080;
inline constexpr std::uint32_t emergency_base = 0x080;
inline constexpr std::uint32_t transmit_pdo_base = 0x180;  ///< 0x180 + node id: AmpStatus, SensorSample
inline constexpr std::uint32_t receive_pdo_base = 0x200;   ///< 0x200 + amplifier's node id: AmpCommand
inline constexpr std::uint32_t controller_status_base = 0x280;
inline constexpr std::uint32_t setpoint_base = 0x300;
inline constexpr std::uint32_t scan_marker_base = 0x380;
inline constexpr std::uint32_t sdo_response_base = 0x580;  ///< 0x580 + server's node id: SDO response
inline constexpr std::uint32_t sdo_request_base = 0x600;   ///< 0x600 + server's node id: SDO request
inline constexpr std::uint32_t heartbeat_base = 0x700;
inline constexpr std::uint8_t sync_counter_max = 240;  ///< the SYNC counter runs from 1 to 240

struct Nmt {
  NmtCommand command;
  std::uint8_t node;  ///< node id of the node that must obey; 0: all nodes
};
struct Emergency {
  std::uint16_t code = 0;
  std::uint8_t error_register = 0;
  std::array<std::uint8_t, 5> manufacturer{};
};

Frame nmt_frame(Nmt nmt);
Frame sync_frame(std::uint8_t counter);
Frame heartbeat_frame(std::uint8_t node, NmtState state);
Frame emergency_frame(std::uint8_t node, Emergency emergency);

/// Each parser returns nullopt if the frame is not well-formed. Only parse_sync() checks the identifier; for
/// the other parsers, the caller must have checked the identifier.
std::optional<Nmt> parse_nmt(const Frame& frame);
std::optional<std::uint8_t> parse_sync(const Frame& frame);
/// Returns true for both forms of a SYNC in CiA 301: with a counter, or without data.
bool is_sync(const Frame& frame);
std::optional<NmtState> parse_heartbeat(const Frame& frame);
std::optional<Emergency> parse_emergency(const Frame& frame);
/// Returns true if the frame is a heartbeat of this node with a valid CiA 301 state.
bool is_heartbeat_of(std::uint8_t node, const Frame& frame);

/// Returns true if a SYNC can have this counter.
constexpr bool is_sync_counter(int counter) { return counter >= 1 && counter <= sync_counter_max; }
/// Returns the SYNC counter after `counter`: 1..240, then 1 again.
constexpr std::uint8_t next_sync_counter(std::uint8_t counter) {
  return counter >= sync_counter_max ? std::uint8_t{1} : static_cast<std::uint8_t>(counter + 1);
}
/// Returns the number of SYNCs from the counter value `earlier` to the counter value `counter`: 0..239. Both
/// values must be within 1..240.
constexpr int syncs_after(int earlier, int counter) {
  return (counter - earlier + sync_counter_max) % sync_counter_max;
}

/// Returns true if the cycle after the SYNC with this counter is a slot of the node. Slots spread heartbeats
/// and periodic statuses over the cycles: in each of its slots, a node may send one of these frames. `slots`:
/// number of cycles in a round of slots; 0 if the bus has no slots.
constexpr bool is_in_slot(std::uint8_t node, std::uint8_t counter, unsigned slots) {
  return slots == 0 || counter % slots == node % slots;
}

/// Returns the meaning of the error code of an emergency (CiA 301, table of emergency error codes). A code
/// that is not in the table has the text of its group, for example 0x2300 or 0x2000 for 0x2310. A code
/// without a group has the text "reserved error code".
std::string_view emergency_text(std::uint16_t code);

/// The NMT part of a node: obeys NMT commands and sends heartbeats. At start() and at each NMT reset, the
/// node sends a boot-up message and becomes pre-operational. The object calls the handler for both states. In
/// the call for boot_up, the program that owns this object must reset the other parts of the node;
/// last_reset() returns which parts.
///
/// If nodes have slots (is_in_slot()), the owner must call on_slot() in each slot of this node, and a due
/// heartbeat waits for this call. If no slot occurred for a whole heartbeat period, because no SYNC arrives,
/// the heartbeat does not wait.
///
/// The node is silent before start(). If the node receives a heartbeat with its own node id, another node
/// uses the same id. The node then stops, calls the handler and stays silent permanently.
class NmtSlave {
 public:
  using ChangeHandler = std::function<void(NmtState)>;

  NmtSlave(Bus& bus, Scheduler& scheduler, std::uint8_t node, Duration heartbeat_period,
           ChangeHandler on_change);

  void start() { boot_up(NmtCommand::reset_node); }
  /// Obeys an NMT frame to this node or to all nodes, detects another node with this node id, and ignores
  /// every other frame.
  void handle(const Frame& frame);
  /// Sends a waiting heartbeat in a slot of this node. Returns true if the heartbeat used the slot, so that
  /// no other frame may follow in the slot.
  bool on_slot();
  NmtState state() const { return state_; }
  /// Returns the kind of the last reset. `reset_node` resets everything, as at power-on.
  /// `reset_communication` resets only the counters of messages and the NMT state.
  NmtCommand last_reset() const { return last_reset_; }
  /// Returns true if another node on the bus uses this node id.
  bool is_taken() const { return id_taken_; }
  bool is_silent() const { return !started_ || id_taken_; }

 private:
  void boot_up(NmtCommand reset);
  void retire();
  void enter(NmtState state);
  void beat();

  Bus& bus_;
  std::uint8_t node_;
  Scheduler& scheduler_;
  Duration period_;
  ChangeHandler on_change_;
  NmtState state_ = NmtState::boot_up;
  NmtCommand last_reset_ = NmtCommand::reset_node;
  bool started_ = false;
  bool id_taken_ = false;
  bool heartbeat_is_due_ = false;
  std::optional<Time> last_slot_;
  std::unique_ptr<Timer> heartbeat_;
};

/// Monitors the heartbeats of another node. The caller supplies the present time; the monitor has no timer.
class HeartbeatMonitor {
 public:
  explicit HeartbeatMonitor(Duration timeout) : timeout_(timeout) {}

  void on_heartbeat(NmtState state, Time now);
  /// Clears the state: state() returns nullopt until the next heartbeat.
  void forget() { state_.reset(); }
  /// Returns the NMT state of the node; nullopt if no heartbeat was received, or if the last heartbeat is
  /// older than the timeout.
  std::optional<NmtState> state(Time now) const;
  /// Returns the number of received boot-up messages. A change of this number means that the node restarted.
  unsigned boot_ups() const { return boot_ups_; }

 private:
  Duration timeout_;
  std::optional<NmtState> state_;
  Time last_{};
  unsigned boot_ups_ = 0;
};

}  // namespace hystcan::can
