// What is known of a stage before the program has measured it.
#pragma once

#include <vector>

#include "config/schema/config.h"
#include "model/reference_curve.h"

namespace hystcan::app {

struct AxisFacts {
  /// As far as it is known: name, unit, drives, mode, sensor's delay and noise, nodes, frames, model files.
  config::AxisConfig config{};
  model::Interval travel_um{};      ///< positions at the ends of the range of the drive
  bool mode_is_measured = false;    ///< resonance and damping are those of a step
  bool damping_is_assumed = false;  ///< neither stated nor measured
};

struct StageFacts {
  config::Config config{};  ///< interface, rate, and the DBC where it lies now; no axes
  std::vector<AxisFacts> axes{};
  bool rate_is_assumed = false;  ///< nobody has stated it
};

}  // namespace hystcan::app
