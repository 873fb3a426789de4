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

 private:
  void handle(const can::Frame& frame, can::Time received);
  void sample(std::uint8_t sync_counter, can::Time received);

  std::unique_ptr<can::Bus> bus_;
  Plant& plant_;
  Sensor sensor_;
  can::NmtSlave nmt_;
  can::SdoServer sdo_;
  can::Encoder<can::SensorSample> encode_sample_;
};

}  // namespace hystcan::twin
