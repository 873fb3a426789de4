// The amplifier as a node on the bus: obeys NMT and AmpCommand, detects when commands stop, sends its status.
//
// A node may have several axes. They share one command frame: an accepted frame has the commands of all axes.
// They may share one status message, or each axis has its own status message. An event that affects several
// axes at the same time causes only one emergency, and only one status if the axes share it.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/protocol/protocol.h"
#include "node/bus_node.h"
#include "node/config.h"

namespace hystcan::node {

/// Bit of the signal Fault in AmpStatus: the fault has a cause within the amplifier, such as its temperature.
/// can::amp_fault has the other bits.
inline constexpr std::uint8_t internal_fault = 0x80;

class AmplifierChannel;

class AmplifierNode final : public BusNode {
 public:
  /// `first`: the first axis of the node. Its command message applies to all axes of the node.
  AmplifierNode(const can::AxisWire& first, const CommonConfig& common, const can::Database& database,
                can::Scheduler& scheduler, const can::Attach& attach);

  const can::E2eChecker& checker() const { return checker_; }
  const std::vector<AmplifierChannel*>& channels() const { return channels_; }
  void shut_down() override;
  void lose_power() override;

 private:
  friend class AmplifierChannel;
  /// A status message and the axes that share it.
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
  /// Returns true if the command is too old to be obeyed (docs/protocol/nodes.md, "Stale commands").
  bool is_stale(const can::AmpCommand& command, can::Time received) const;
  void check_watchdogs();
  void check_relays();
  void note_emergency(std::uint16_t code);
  /// Sends the status of each axis that received AmplifierConfig::status_every SYNCs since its last status.
  /// If the bus has slots (can::is_in_slot), this function is called only in a slot of the node. It then
  /// sends the status of at most one axis: the axis whose last status is the oldest.
  void report_regularly();
  /// Sends the waiting emergencies and every status that is due.
  void report();
  void send(StatusMessage& message);

  can::Scheduler& scheduler_;
  can::Duration cycle_;
  std::uint32_t command_id_;
  can::E2eChecker checker_;
  std::vector<AmplifierChannel*> channels_;
  std::vector<StatusMessage> statuses_;
  std::vector<std::uint16_t> emergencies_;  ///< error codes of the emergencies that report() will send
  std::uint8_t last_sync_ = 0;
  can::Time last_sync_at_{};
  std::optional<can::Time> former_sync_at_;  ///< time of the SYNC before the last SYNC; empty if the node did
                                             ///< not receive that SYNC
};

}  // namespace hystcan::node
