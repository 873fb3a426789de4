// One axis of a twin: the stage, one channel on each of its two nodes, and their connections.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "can/bus.h"
#include "node/amplifier_channel.h"
#include "node/sensor_channel.h"
#include "twin/config.h"
#include "twin/faulty_connection.h"
#include "twin/simulated_amplifier.h"
#include "twin/simulated_sensor.h"

namespace hystcan::twin {

/// A node of the twin and the node's connection to the bus. Several axes may share a node.
template <class Made>
struct Connected {
  Made* node = nullptr;
  FaultyConnection* line = nullptr;
};

/// The parts of an axis on which its faults act.
struct FaultTarget {
  node::BusNode& node(Node which) const;
  FaultyConnection& line(Node which) const { return which == Node::amplifier ? amplifier_line : sensor_line; }
  std::size_t channel(Node which) const {
    return which == Node::amplifier ? amplifier.index() : sensor.index();
  }

  can::AxisWire wire;
  Plant& plant;
  node::AmplifierChannel& amplifier;
  node::SensorChannel& sensor;
  FaultyConnection& amplifier_line;
  FaultyConnection& sensor_line;
};

struct Axis {
  Axis(const WiredAxisConfig& config, const CommonConfig& common, const can::Database& database,
       can::Scheduler& scheduler, const Connected<node::AmplifierNode>& of_amplifier,
       const Connected<node::SensorNode>& of_sensor);
  Axis(const Axis&) = delete;
  Axis& operator=(const Axis&) = delete;

  FaultTarget fault_target() { return {wire, plant, amplifier, sensor, amplifier_line, sensor_line}; }

  std::string name;
  can::AxisWire wire;
  Plant plant;
  SimulatedAmplifier amplifier_device;
  node::AmplifierChannel amplifier;
  SimulatedSensor sensor_device;
  node::SensorChannel sensor;
  DriveNoise drive_noise;
  FaultyConnection& amplifier_line;
  FaultyConnection& sensor_line;
};
using Axes = std::vector<std::unique_ptr<Axis>>;

}  // namespace hystcan::twin
