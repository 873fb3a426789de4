// The result of `hystcan tune` as text, as a fragment of a configuration and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "controller/analysis/loop_design.h"
#include "controller/control/law.h"
#include "controller/control/statistics.h"
#include "controller/reference/excitation.h"
#include "identification/dynamics/second_order_fit.h"

namespace hystcan::app {

/// Present or proposed settings of an axis, and their predicted effect.
struct Setting {
  controller::Pi::Config pi;
  controller::Delays delays;
  std::optional<controller::JudgedLoop> loop{};      ///< empty if ki is zero: there is no loop to judge
  std::vector<controller::AxisOutcome> predicted{};  ///< for the configured reference, by all_structures
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
  controller::CautiousRule rule;
  Setting present;
  Setting proposed;
};

std::string describe(const TuningReport& report);
/// The keys of [axis.control] to replace, each with its present value in a comment.
std::string fragment(const TuningReport& report);
nlohmann::json to_json(const TuningReport& report);

}  // namespace hystcan::app
