// The facts that are known about a stage before the program measures it.
#pragma once

#include <vector>

#include "config/schema/config.h"
#include "model/reference_curve.h"

namespace hystcan::app {

struct AxisFacts {
  /// Contains the known values: names, unit, drive limits, mode, delay and noise of the sensor, node numbers,
  /// frames and model files. All other values are defaults.
  config::AxisConfig config{};
  model::Interval travel_um{};      ///< positions at both ends of the drive range
  bool mode_is_measured = false;    ///< true if a step record determined resonance and damping
  bool damping_is_assumed = false;  ///< true if the damping is neither stated nor measured
};

struct StageFacts {
  config::Config config{};  ///< interface, rate and path of the DBC; contains no axes
  std::vector<AxisFacts> axes{};
  /// True if the cycle rate is the default, 1000 Hz, and the option --cycle-rate did not set it.
  bool rate_is_assumed = false;
};

}  // namespace hystcan::app
