// The position sensor as a node on the bus: one sample per SYNC, taken when the SYNC arrives.
#pragma once

#include <memory>

#include "can/bus.h"
#include "can/node.h"
#include "can/protocol.h"
#include "twin/plant.h"
#include "twin/sensor.h"

namespace hystcan::twin {

class SensorNode {
 public:
  struct Config {
    can::AxisWire wire;
    can::Duration heartbeat_period{};
  };

  SensorNode(const Config& config, const can::Database& database, can::Scheduler& scheduler,
             std::unique_ptr<can::Bus> bus, Plant& plant, const Sensor& sensor);

  void start() { nmt_.start(); }
  /// Somebody else on the bus is this node: it is off and silent.
  bool is_taken() const { return nmt_.is_taken(); }

  const can::Bus& bus() const { return *bus_; }
  can::NmtState state() const { return nmt_.state(); }
  bool is_on_the_bus() const { return !nmt_.is_silent(); }

  /// The supply was gone: the node comes back as at its first start; nothing where it never started.
  void restart();

 private:
  void handle(const can::Frame& frame, can::Time received);
  void sample(std::uint8_t sync_counter, can::Time received);
  void forget_everything();

  std::unique_ptr<can::Bus> bus_;
  Plant& plant_;
  Sensor sensor_;
  can::NmtSlave nmt_;
  can::SdoServer sdo_;
  can::Encoder<can::SensorSample> encode_sample_;
  can::Encoder<can::SensorSample> encode_sample_at_power_on_;
};

}  // namespace hystcan::twin
