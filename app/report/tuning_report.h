// What `hystcan tune` has found, in words, as a fragment of a configuration and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "controller/control/law.h"
#include "controller/control/statistics.h"
#include "controller/reference/excitation.h"
#include "identification/dynamics/tuning.h"

namespace hystcan::app {

/// What an axis is set to, or might be, and what comes of it.
struct Setting {
  controller::Pi::Config pi;
  controller::Delays delays;
  std::optional<identification::Tuning> loop{};      ///< empty: ki is zero, no loop that could be judged
  std::vector<controller::AxisOutcome> predicted{};  ///< of the configured reference, by all_structures
};

struct TuningReport {
  std::string config;  ///< the file's name, without its folder
  std::string axis;
  std::string drive_unit;
  std::string actuator;  ///< the model file of the twin
  bool rehearsed = false;
  controller::Excitation::Steps steps;
  double rate_Hz = 0.0;
  identification::SecondOrderFit fit;
  identification::PiRule rule;
  Setting present;
  Setting proposed;
};

std::string describe(const TuningReport& report);
/// The keys of [axis.control] that are to be replaced, each with what it was.
std::string fragment(const TuningReport& report);
nlohmann::json to_json(const TuningReport& report);

}  // namespace hystcan::app
