#include "twin/simulated_sensor.h"

#include <utility>

namespace hystcan::twin {

SimulatedSensor::SimulatedSensor(Sensor sensor, Plant& plant, can::Time start)
    : sensor_(std::move(sensor)), plant_(plant) {
  if (!sensor_.follows()) return;
  sensor_.follow(start, plant.position_um());
  plant.on_grid([this](can::Time time, double position_um) { sensor_.follow(time, position_um); });
}

node::PositionInput::Reading SimulatedSensor::read(can::Time at) {
  plant_.advance_to(at);
  const Sensor::Reading reading = sensor_.measure(at, plant_.position_um());
  return {.position_um = reading.position_um,
          .status = reading.in_range ? std::uint8_t{0} : node::sensor_status::out_of_range};
}

}  // namespace hystcan::twin
