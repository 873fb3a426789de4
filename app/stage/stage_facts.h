// What is known of a stage before the program has measured it.
#pragma once

#include <string>
#include <vector>

#include "config/schema/config.h"
#include "model/reference_curve.h"

namespace hystcan::app {

struct AxisFacts {
  /// A role of the lab's own frames, and why the signal is thought to have it.
  struct Row {
    std::string role;  ///< "command.setpoint"
    std::string message, signal;
    std::string because;  ///< "mV, set"
  };

  /// As far as it is known: name, unit, drives, mode, sensor's delay and noise, nodes, frames, model files.
  config::AxisConfig config{};
  model::Interval travel_um{};      ///< positions at the ends of the range of the drive
  bool mode_is_measured = false;    ///< resonance and damping are those of a step
  bool damping_is_assumed = false;  ///< neither stated nor measured
  std::vector<Row> roles{};
  std::vector<std::string> not_found{};          ///< roles, and what a DBC cannot say
  std::vector<std::string> enable_candidates{};  ///< signals of the lab's command that may be its enable
};

struct StageFacts {
  config::Config config{};  ///< interface, rate, and the DBC where it lies now; no axes
  std::vector<AxisFacts> axes{};
  bool rate_is_assumed = false;  ///< nobody has stated it
};

}  // namespace hystcan::app
