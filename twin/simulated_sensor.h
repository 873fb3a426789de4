// The position sensor of a simulated plant, as the input that its bus node reads.
#pragma once

#include "node/position_input.h"
#include "twin/plant.h"
#include "twin/sensor.h"

namespace hystcan::twin {

class SimulatedSensor final : public node::PositionInput {
 public:
  /// From `start` on, a sensor with a bandwidth or a delay receives the plant's position at the end of every
  /// sub-step of the plant.
  SimulatedSensor(Sensor sensor, Plant& plant, can::Time start);

  Reading read(can::Time at) override;

 private:
  Sensor sensor_;
  Plant& plant_;
};

}  // namespace hystcan::twin
