// The common part of an amplifier node and a sensor node: its connection to the bus, NMT, heartbeat and SDO
// server.
//
// A node serves one or several axes. For each of its axes, the node has a channel: an AmplifierChannel or a
// SensorChannel.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "can/bus.h"
#include "can/protocol/node.h"
#include "can/protocol/sdo.h"
#include "node/config.h"

namespace hystcan::node {

class BusNode {
 public:
  virtual ~BusNode() = default;
  BusNode(const BusNode&) = delete;
  BusNode& operator=(const BusNode&) = delete;

  void start() { nmt_.start(); }
  /// Returns true if another node on the bus has the same number. This node is then off and silent.
  bool is_taken() const { return nmt_.is_taken(); }
  bool is_on_the_bus() const { return !nmt_.is_silent(); }
  /// Switches an amplifier node off: sets its outputs to the safe value and sends a last status. Does nothing
  /// in a sensor node.
  virtual void shut_down() {}

  std::uint8_t number() const { return number_; }
  can::NmtState state() const { return nmt_.state(); }
  const can::SdoServer& objects() const { return sdo_; }
  const can::Bus& bus() const { return *bus_; }

  /// Simulates a failure of the supply voltage: the outputs of an amplifier move to their safe value. The
  /// caller must discard the frames that the node sends.
  virtual void lose_power() {}
  /// Simulates the return of the supply voltage: the node boots up again. Has no effect before start(). If
  /// is_taken() is true, another node has the number of this node, and this node stays off.
  void restart();

 protected:
  /// `obeys`: the message that the node receives in addition to the frames of CiA 301 (NMT, SYNC, heartbeat,
  /// SDO).
  BusNode(std::uint8_t number, const CommonConfig& common, can::Scheduler& scheduler,
          const can::Attach& attach, const std::optional<can::Filter>& obeys = {});

  can::Bus& line() { return *bus_; }
  /// Processes a received frame: an NMT command, an SDO request to this node, or a heartbeat. A heartbeat
  /// with the number of this node means that another node has the same number. This node then becomes silent.
  void handle(const can::Frame& frame);
  /// Call at each SYNC, with its counter. Returns true if the node may send a regular status in this cycle.
  /// With `background_slots`, a node may send heartbeats and regular statuses only in certain cycles, its
  /// slots. In a slot, this function sends the heartbeat if it is due. If the slot is used for that, it
  /// returns false.
  bool take_slot(std::uint8_t sync_counter);
  bool has_slot() const { return slots_ != 0; }
  /// Called after each change of the NMT state. Before the call for a boot-up after the NMT command `reset
  /// node`, all values that were written by SDO are deleted.
  virtual void on_nmt(can::NmtState state) = 0;
  can::NmtCommand last_reset() const { return nmt_.last_reset(); }

 private:
  std::uint8_t number_;
  unsigned slots_;
  std::unique_ptr<can::Bus> bus_;
  can::NmtSlave nmt_;
  can::SdoServer sdo_;
};

}  // namespace hystcan::node
