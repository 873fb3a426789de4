// The linear loop of a configured axis (controller/analysis/linear_loop.h): an unstable one is refused.
#pragma once

#include <string>
#include <vector>

#include "config/document/document.h"
#include "config/schema/config.h"
#include "controller/analysis/loop_design.h"

namespace hystcan::config {

/// The resonance may be this far off: where the loop then has no margin, findings_of_loop() warns.
inline constexpr double resonance_off_percent = 10.0;

/// Throws Error where the loop is unstable for the delays that the axis itself states.
void check_loop(const Document& document, const Config& config, std::size_t axis);

/// Designs the filters of the axis: of its feed-forward and of its learning, where it has them. Throws Error where it
/// cannot learn.
void plan_filters(const Document& document, Config& config, std::size_t axis);

/// Margins for the stated plant, and the worst ones with its resonance off.
controller::JudgedLoop judged_loop(const AxisConfig& axis, double rate_Hz);

/// Lines for `check`: margins, sensitivity, bandwidth; a line that begins with "warning: " where the margin is lost with
/// the resonance off.
std::vector<std::string> findings_of_loop(const AxisConfig& axis, double rate_Hz);

/// Lines for `check`: what the learning learns of each segment, up to which frequency, and how fast.
std::vector<std::string> findings_of_learning(const AxisConfig& axis, double rate_Hz);

}  // namespace hystcan::config
