// The common part of an amplifier node and a sensor node: the connection, NMT, heartbeat and SDO server.
//
// A node serves one axis or several. Each of its axes is a channel: AmplifierChannel, SensorChannel.
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
  /// True if another node on the bus has the same number; this node is then off and silent.
  bool is_taken() const { return nmt_.is_taken(); }
  bool is_on_the_bus() const { return !nmt_.is_silent(); }
  /// Switches off: sets the outputs of an amplifier to the safe value and reports this in a last status.
  virtual void shut_down() {}

  std::uint8_t number() const { return number_; }
  can::NmtState state() const { return nmt_.state(); }
  const can::SdoServer& objects() const { return sdo_; }
  const can::Bus& bus() const { return *bus_; }

  /// Simulates a supply failure: the outputs of an amplifier fall to their safe value. The caller discards
  /// the frames of the node.
  virtual void lose_power() {}
  /// Simulates the return of the supply: the node boots up again. Has no effect before the first start.
  void restart();

 protected:
  /// `obeys`: the message that the node receives in addition to those of CiA 301.
  BusNode(std::uint8_t number, const CommonConfig& common, can::Scheduler& scheduler,
          const can::Attach& attach, const std::optional<can::Filter>& obeys = {});

  can::Bus& line() { return *bus_; }
  /// Handles NMT, SDO and heartbeats with the number of this node.
  void handle(const can::Frame& frame);
  /// Call at each SYNC. If frames have slots, sends a heartbeat that is due in the slot of the node. Returns
  /// true if the node may send another frame.
  bool take_slot(std::uint8_t sync_counter);
  bool has_slot() const { return slots_ != 0; }
  /// Called after each change of the NMT state. At boot-up, a reset of the objects is already done.
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
