// The state of one other node on the bus, as the controller receives it: its heartbeat, its emergencies, and
// the state of its set-up.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "can/protocol/node.h"
#include "can/protocol/protocol.h"
#include "can/protocol/sdo.h"

namespace hystcan::controller {

/// A frame that another node sent, although only this controller may send it.
struct ForeignFrame {
  enum class Kind : std::uint8_t { sync, heartbeat, command, axis_status };
  Kind kind = Kind::sync;
  std::uint32_t id = 0;
  bool extended = false;
  friend bool operator==(const ForeignFrame&, const ForeignFrame&) = default;
};

/// An event of a node for the log.
struct NodeEvent {
  enum class Kind : std::uint8_t {
    emergency,
    not_set_up,
    foreign_nmt,
    foreign_sdo,
    no_such_sync,       ///< a sample contains a SYNC counter that no SYNC has
    outside_slot,       ///< heartbeats and statuses arrive outside the slot of the node
    another_controller  ///< another controller sends; its node id is unknown
  };
  Kind kind = Kind::emergency;
  std::uint8_t node = 0;
  can::Emergency emergency{};
  can::SdoFailure failure{};
  can::NmtCommand command{};      ///< the foreign command; only for the kind foreign_nmt
  can::SdoObject object{};        ///< the written object; only for the kind foreign_sdo
  std::uint8_t sync_counter = 0;  ///< SYNC counter; only for the kinds no_such_sync and outside_slot
  unsigned slots = 0;             ///< number of cycles in a round of slots; only for the kind outside_slot
  ForeignFrame frame{};           ///< the foreign frame; only for the kind another_controller
  std::uint32_t times = 1;        ///< number of equal consecutive events that this event stands for
};
static_assert(std::is_trivially_copyable_v<std::optional<NodeEvent>>,
              "a NodeEvent must be trivially copyable, because it crosses threads");

/// True if both events report the same: kind, node, code, command, object and frame are equal.
bool are_of_one_kind(const NodeEvent& one, const NodeEvent& other);
/// True if the event is an emergency that only reports the end of an error (CiA 301: code 00xx, "error reset
/// or no error").
bool is_all_clear(const NodeEvent& event);

/// Describes the event in one line. Example: "node 1: emergency 0x8130: life guard or heartbeat error (error
/// register 0x01)".
std::string describe(const NodeEvent& event);

/// Numbers of commands and requests that other nodes have sent to a node that only this controller may
/// command.
struct ForeignAccess {
  std::uint64_t nmt = 0;
  std::uint64_t sdo_writes = 0;
  std::uint64_t sdo_reads = 0;
};
/// Describes the commands and requests in `access`. Example: "2 NMT commands, 1 SDO write, 30 SDO reads of
/// another node". Returns an empty text if there was no access.
std::string describe(const ForeignAccess& access);

/// The meaning of a received heartbeat.
enum class Heartbeat : std::uint8_t { rejected, boot_up, new_state, as_before };

/// One remote node. The node is set up before it is started. It is set up again after each boot-up, because
/// it may have lost its set-up.
class RemoteNode {
 public:
  RemoteNode(std::uint8_t node, can::Duration heartbeat_timeout, can::SdoSetup setup);

  Heartbeat on_heartbeat(const can::Frame& frame, can::Time now);
  void on_emergency(const can::Frame& frame);
  void on_sdo(const can::Frame& frame);
  /// Records an NMT frame, or an SDO request to this node, from another node. Returns true if the frame may
  /// change what the node does. If the frame may have changed the set-up of the node, the node is set up
  /// again before it is used again.
  bool on_foreign_nmt(const can::Frame& frame);
  bool on_foreign_sdo(const can::Frame& frame);
  /// Records that a sample of this node contains a SYNC counter that no SYNC has.
  void note_no_such_sync(std::uint8_t sync_counter);
  /// Records a heartbeat or a periodic status, which arrived after the SYNC with this counter. Such frames
  /// must arrive in the slot of the node. If three more frames have arrived outside the slot than inside,
  /// makes one event for the log.
  void note_background_frame(std::uint8_t sync_counter, unsigned slots);

  std::uint8_t node() const { return node_; }
  /// Returns the node's state; `nullopt` if no heartbeat has arrived, or if the last one is too old.
  std::optional<can::NmtState> state(can::Time now) const { return heartbeat_.state(now); }
  /// True if the node is operational and its set-up is complete.
  bool is_operational(can::Time now) const {
    return setup_.is_done() && state(now) == can::NmtState::operational;
  }
  bool is_set_up() const { return setup_.is_done(); }
  /// These checkers count the invalid heartbeats, emergencies and SDO responses.
  const can::E2eChecker& heartbeat_checker() const { return heartbeat_checker_; }
  const can::E2eChecker& emergency_checker() const { return emergency_checker_; }
  const can::E2eChecker& sdo_checker() const { return sdo_checker_; }
  const ForeignAccess& foreign_access() const { return foreign_; }
  /// Returns the number of frames that arrived outside the node's slot. Returns 0 until three more frames
  /// have arrived outside the slot than inside, because one or two frames may be late.
  std::uint64_t outside_slot() const { return keeps_slot_ ? 0 : outside_slot_; }

  /// Called after the bus was off: discards the node's state and set-up, which may not be valid any more.
  void forget();

  /// Returns the next request of the set-up. Returns `nullopt` if no request is due, or if the node is absent
  /// or stopped.
  std::optional<can::Frame> poll_setup(can::Time now);
  bool setup_has_failed() const { return setup_.has_failed(); }
  /// If the set-up has failed, tries it once more.
  void retry_setup();

  /// True if the node has booted up since the last call.
  bool take_restart() {
    return std::exchange(boot_ups_seen_, heartbeat_.boot_ups()) != heartbeat_.boot_ups();
  }
  /// True if an emergency with a code other than "no error" has arrived since the last call.
  bool take_alarm() { return std::exchange(alarm_, false); }
  /// Returns the oldest event that was not taken yet. Equal consecutive events are counted as one. If
  /// more than sixteen events are waiting, the later events are lost, except for the last event.
  std::optional<NodeEvent> take_event();

 private:
  void note(const NodeEvent& event);
  void set_up_again();

  std::uint8_t node_;
  can::HeartbeatMonitor heartbeat_;
  can::E2eChecker heartbeat_checker_{can::Protection{}, 1, false};
  can::E2eChecker emergency_checker_{can::Protection{}, 8, false};
  can::E2eChecker sdo_checker_{can::Protection{}, 8, false};
  can::SdoSetup setup_;
  ForeignAccess foreign_;
  std::uint64_t outside_slot_ = 0;
  /// Increases by one if a heartbeat or a periodic status arrives outside the slot of the node, and decreases
  /// by one if it arrives inside. Never below 0.
  unsigned more_outside_ = 0;
  bool keeps_slot_ = true;
  bool failure_noted_ = false;
  bool alarm_ = false;
  unsigned boot_ups_seen_ = 0;
  std::array<NodeEvent, 16> events_{};
  std::size_t event_count_ = 0;
};

}  // namespace hystcan::controller
