// What really was, beside what was asked for and what was measured: three signals that catch an error of sign
// or scale in any of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "can/scheduler.h"

namespace hystcan::twin {

/// Of one axis, at the moment of a sample.
struct Truth {
  can::Time time;  ///< the scheduler's: CLOCK_MONOTONIC, or virtual
  std::size_t axis = 0;
  std::uint8_t sync_counter = 0;  ///< as the sample names it
  double setpoint = 0.0;          ///< last commanded, drive units
  double drive = 0.0;             ///< what the actuator gets, noise included, drive units
  double hysteresis_um = 0.0;     ///< output of the hysteresis
  double position_um = 0.0;       ///< what the sensor sees
  double measured_um = 0.0;       ///< what it measures, before faults act on the frame
};

using TruthHandler = std::function<void(const Truth&)>;

}  // namespace hystcan::twin
