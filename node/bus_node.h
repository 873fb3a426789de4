// What an amplifier node and a sensor node have in common: the connection, NMT, heartbeat and SDO server.
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
  /// Another node on the bus has the same number: this node is off and silent.
  bool is_taken() const { return nmt_.is_taken(); }
  bool is_on_the_bus() const { return !nmt_.is_silent(); }
  /// Switches off; an amplifier's outputs go to the safe value, and a last status reports it.
  virtual void shut_down() {}

  std::uint8_t number() const { return number_; }
  can::NmtState state() const { return nmt_.state(); }
  const can::SdoServer& objects() const { return sdo_; }
  const can::Bus& bus() const { return *bus_; }

  /// The supply fails: an amplifier's outputs fall to their safe value. The caller discards the frames of the
  /// node.
  virtual void lose_power() {}
  /// The supply returns: the node starts as at its first start. No effect before the first start.
  void restart();

 protected:
  /// `obeys`: the message that it receives beside those of CiA 301.
  BusNode(std::uint8_t number, const CommonConfig& common, can::Scheduler& scheduler,
          const can::Attach& attach, const std::optional<can::Filter>& obeys = {});

  can::Bus& line() { return *bus_; }
  /// NMT, heartbeats of the same number and SDO.
  void handle(const can::Frame& frame);
  /// With each SYNC. Where frames have slots, sends the heartbeat in that of the node, if it is due. True:
  /// the node may send another frame.
  bool take_slot(std::uint8_t sync_counter);
  bool has_slot() const { return slots_ != 0; }
  /// At boot-up the objects are already reset, if they are.
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
