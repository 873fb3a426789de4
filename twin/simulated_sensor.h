// The sensor of a simulated plant, read by its node.
#pragma once

#include "node/position_input.h"
#include "twin/plant.h"
#include "twin/sensor.h"

namespace hystcan::twin {

class SimulatedSensor final : public node::PositionInput {
 public:
  /// Receives every grid point of the plant from `start` on if the reading depends on the past.
  SimulatedSensor(Sensor sensor, Plant& plant, can::Time start);

  Reading read(can::Time at) override;

 private:
  Sensor sensor_;
  Plant& plant_;
};

}  // namespace hystcan::twin
