// The position sensor of a simulated plant, as the input that its bus node reads.
#pragma once

#include "node/position_input.h"
#include "twin/plant.h"
#include "twin/sensor.h"

namespace hystcan::twin {

class SimulatedSensor final : public node::PositionInput {
 public:
  /// If the sensor has a bandwidth or a delay, it receives the plant's position at every grid point from
  /// `start` on.
  SimulatedSensor(Sensor sensor, Plant& plant, can::Time start);

  Reading read(can::Time at) override;

 private:
  Sensor sensor_;
  Plant& plant_;
};

}  // namespace hystcan::twin
