// The known facts about a stage before the program has measured it.
#pragma once

#include <vector>

#include "config/schema/config.h"
#include "model/reference_curve.h"

namespace hystcan::app {

struct AxisFacts {
  /// Contains the known values: name, unit, drives, mode, sensor's delay and noise, nodes, frames, model
  /// files.
  config::AxisConfig config{};
  model::Interval travel_um{};      ///< positions at the ends of the range of the drive
  bool mode_is_measured = false;    ///< resonance and damping were identified from a step
  bool damping_is_assumed = false;  ///< neither stated nor measured
};

struct StageFacts {
  config::Config config{};  ///< interface, rate, and the present path of the DBC; no axes
  std::vector<AxisFacts> axes{};
  bool rate_is_assumed = false;  ///< the rate is not stated
};

}  // namespace hystcan::app
