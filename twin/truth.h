// The true state of a simulated stage, together with the commanded and the measured values. A comparison of
// these three shows an error of sign or scale in any of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "can/scheduler.h"

namespace hystcan::twin {

/// The true state of one axis at the time of a sample.
struct Truth {
  can::Time time;  ///< the scheduler's: CLOCK_MONOTONIC, or virtual
  std::size_t axis = 0;
  std::uint8_t sync_counter = 0;  ///< as in the sample
  double setpoint = 0.0;          ///< last commanded, drive units
  double drive = 0.0;             ///< input of the actuator, noise included, drive units
  double hysteresis_um = 0.0;     ///< output of the hysteresis
  double position_um = 0.0;       ///< input of the sensor
  double measured_um = 0.0;       ///< output of the sensor, before faults act on the frame
};

using TruthHandler = std::function<void(const Truth&)>;

}  // namespace hystcan::twin
