// What the controller knows of one other node: its heartbeat, its emergencies, and whether it is set up.
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

/// A frame that only this controller sends, from another node.
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
    no_such_sync,       ///< a sample names a SYNC that there is not
    outside_slot,       ///< heartbeats and statuses come outside of the slot of the node
    another_controller  ///< the node is not known
  };
  Kind kind = Kind::emergency;
  std::uint8_t node = 0;
  can::Emergency emergency{};
  can::SdoFailure failure{};
  can::NmtCommand command{};      ///< of foreign_nmt
  can::SdoObject object{};        ///< of foreign_sdo
  std::uint8_t sync_counter = 0;  ///< of no_such_sync and outside_slot
  unsigned slots = 0;             ///< of outside_slot: of a round
  ForeignFrame frame{};           ///< of another_controller
  std::uint32_t times = 1;        ///< so many of this kind came in a row before the first was taken
};
static_assert(std::is_trivially_copyable_v<std::optional<NodeEvent>>, "events cross threads in a record");

/// True for the same failure of the same node: kind and code.
bool are_of_one_kind(const NodeEvent& one, const NodeEvent& other);
/// True for an emergency that only says that an error has gone (CiA 301: 00xx, "error reset or no error").
bool is_all_clear(const NodeEvent& event);

/// "node 1: emergency 0x8130: life guard or heartbeat error (error register 0x01)".
std::string describe(const NodeEvent& event);

/// What other nodes have sent to a node that only this controller commands.
struct ForeignAccess {
  std::uint64_t nmt = 0;
  std::uint64_t sdo_writes = 0;
  std::uint64_t sdo_reads = 0;
};
/// "2 NMT commands, 1 SDO write, 30 SDO reads of another node"; empty if there was none.
std::string describe(const ForeignAccess& access);

/// What a heartbeat says.
enum class Heartbeat : std::uint8_t { rejected, boot_up, new_state, as_before };

/// A node is set up before it is started, and again after each boot-up, because it may have lost its set-up.
class RemoteNode {
 public:
  RemoteNode(std::uint8_t node, can::Duration heartbeat_timeout, can::SdoSetup setup);

  Heartbeat on_heartbeat(const can::Frame& frame, can::Time now);
  void on_emergency(const can::Frame& frame);
  void on_sdo(const can::Frame& frame);
  /// An NMT frame, or an SDO request to this node, of another node. True: it may change what the node does.
  /// Where it may have changed the set-up, the node is set up again before it is used again.
  bool on_foreign_nmt(const can::Frame& frame);
  bool on_foreign_sdo(const can::Frame& frame);
  /// A sample of this node has this `SyncCounter`, which no SYNC has.
  void note_no_such_sync(std::uint8_t sync_counter);
  /// A heartbeat or a status with nothing new has come after this SYNC. Where three more are outside of the
  /// slot of the node than within, the log says so, once.
  void note_background_frame(std::uint8_t sync_counter, unsigned slots);

  std::uint8_t node() const { return node_; }
  /// Empty if no heartbeat has come, or none for too long.
  std::optional<can::NmtState> state(can::Time now) const { return heartbeat_.state(now); }
  /// Operational, and its set-up is complete.
  bool is_operational(can::Time now) const {
    return setup_.is_done() && state(now) == can::NmtState::operational;
  }
  bool is_set_up() const { return setup_.is_done(); }
  /// They count the invalid frames in the place of heartbeat, emergency and SDO response.
  const can::E2eChecker& heartbeat_checker() const { return heartbeat_checker_; }
  const can::E2eChecker& emergency_checker() const { return emergency_checker_; }
  const can::E2eChecker& sdo_checker() const { return sdo_checker_; }
  const ForeignAccess& foreign_access() const { return foreign_; }
  /// Frames outside of its slot; 0 of a node that keeps it.
  std::uint64_t outside_slot() const { return keeps_slot_ ? 0 : outside_slot_; }

  /// The bus was off: neither the last state nor the set-up may still be valid.
  void forget();

  /// The next request of the set-up, once the node is present.
  std::optional<can::Frame> poll_setup(can::Time now);
  bool setup_has_failed() const { return setup_.has_failed(); }
  /// A set-up that has failed is tried once more.
  void retry_setup();

  /// The node has booted up since the last call.
  bool take_restart() {
    return std::exchange(boot_ups_seen_, heartbeat_.boot_ups()) != heartbeat_.boot_ups();
  }
  /// An emergency of another code than "no error" came since the last call.
  bool take_alarm() { return std::exchange(alarm_, false); }
  /// The oldest event not yet taken. Equal ones in a row are counted as one. More than sixteen are lost but
  /// for the last.
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
  unsigned more_outside_ = 0;  ///< than in its slot
  bool keeps_slot_ = true;
  bool failure_noted_ = false;
  bool alarm_ = false;
  unsigned boot_ups_seen_ = 0;
  std::array<NodeEvent, 16> events_{};
  std::size_t event_count_ = 0;
};

}  // namespace hystcan::controller
