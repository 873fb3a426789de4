#include "config/schema/check.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "controller/analysis/feed_forward_design.h"
#include "controller/analysis/learning_design.h"

namespace hystcan::config {
namespace {

using controller::Margins;

controller::LoopConfig loop_of(const AxisConfig& axis, double rate_Hz) {
  return controller::loop_config_of(axis.control.law, axis.control.delays, 1.0 / rate_Hz);
}

std::string gains_of(const controller::PiGains& pi) {
  return fmt::format("kp {:g}, ki_per_s {:g}", pi.kp, pi.ki_per_s);
}

std::string text_of(const Margins& margins) {
  return fmt::format("phase margin {:.0f} deg, gain margin {:.1f} dB, sensitivity at most {:.2f}",
                     margins.phase_margin_deg, 20.0 * std::log10(margins.gain_margin),
                     margins.peak_sensitivity);
}

/// Peak sensitivity above which a warning is given: the loop amplifies the error of a disturbance more than
/// threefold.
constexpr double too_sensitive = 3.0;

}  // namespace

void check_loop(const Checked& checked, std::size_t index) {
  const Config& config = checked.config;
  const AxisConfig& axis = config.axes[index];
  const controller::PiGains& pi = axis.control.law.pi;
  const controller::LinearLoop loop(loop_of(axis, config.controller.rate_Hz));
  if (controller::margins_of(loop, pi).stable) return;
  const controller::PiGains stable = controller::largest_stable_gains(loop, pi);
  if (stable.ki_per_s > 0.0)
    checked.fail(pi.ki_per_s,
                 "the loop is unstable with {}, expected ki_per_s of at most {:g} for the plant in "
                 "[axis.control.delays]; `hystcan tune` finds gains with margin",
                 gains_of(pi), stable.ki_per_s);
  if (stable.kp == 0.0)
    checked.fail(
        axis.control.delays.damping_ratio,
        "the loop is unstable with {}, and no kp or ki_per_s above 0 is stable for "
        "the plant in [axis.control.delays], whose damping_ratio is {:g}, expected a larger damping_ratio",
        gains_of(pi), axis.control.delays.damping_ratio);
  checked.fail(pi.kp,
               "the loop is unstable with {}, expected kp below {:g} and ki_per_s = 0 for the plant in "
               "[axis.control.delays]; `hystcan tune` finds gains with margin",
               gains_of(pi), stable.kp);
}

void plan_filters(const Document& document, Config& config, std::size_t index) {
  controller::AxisConfig& control = config.axes[index].control;
  controller::plan_feed_forward(control, config.controller.rate_Hz);
  try {
    controller::plan_learning(control, config.controller.rate_Hz);
  } catch (const std::invalid_argument& error) {
    throw Error(Checked{document, config}.place_of(*control.learning), error);
  }
}

controller::JudgedLoop judged_loop(const AxisConfig& axis, double rate_Hz) {
  return controller::judge(loop_of(axis, rate_Hz),
                           controller::around(axis.control.delays, resonance_off_percent));
}

bool rings_at(const AxisConfig& axis, double rate_Hz) {
  const controller::Delays& delays = axis.control.delays;
  return !delays.interpolated && controller::rings_between_samples(delays.resonance_Hz / rate_Hz);
}

std::string line_of(const Finding& finding) {
  return finding.is_warning ? "warning: " + finding.text : finding.text;
}

std::vector<Finding> findings_of_rate(const AxisConfig& axis, double rate_Hz) {
  if (!rings_at(axis, rate_Hz)) return {};
  const double resonance_Hz = axis.control.delays.resonance_Hz;
  return {
      {true,
       fmt::format(
           "the mode of {:g} Hz is near {:g} times the cycle rate of {:g} Hz: setpoints that change "
           "once per cycle excite it, and the samples do not show this; `hystcan tune` finds a better rate",
           resonance_Hz, std::round(resonance_Hz / rate_Hz), rate_Hz)}};
}

std::vector<Finding> findings_of_loop(const AxisConfig& axis, double rate_Hz) {
  const controller::JudgedLoop loop = judged_loop(axis, rate_Hz);
  if (const auto& [kp, ki_per_s] = axis.control.law.pi; kp == 0.0 && ki_per_s == 0.0)
    return {{false, "kp and ki_per_s are 0, so there is no feedback loop"}};
  std::vector<Finding> findings{{false, fmt::format("the loop is stable: {}; bandwidth {:.3g} Hz",
                                                    text_of(loop.margins), loop.margins.bandwidth_Hz)}};
  if (!loop.worst.stable)
    findings.push_back(
        {true,
         fmt::format(
             "if the resonance differs from resonance_Hz by {:g} %, the loop is unstable: lower ki_per_s, or "
             "set a notch; `hystcan tune` finds both",
             resonance_off_percent)});
  else {
    const bool has_little_margin = loop.worst.peak_sensitivity > too_sensitive;
    findings.push_back(
        {has_little_margin,
         fmt::format("{}if the resonance differs from resonance_Hz by {:g} %: {}",
                     has_little_margin ? "little margin " : "", resonance_off_percent, text_of(loop.worst))});
  }
  return findings;
}

std::vector<std::string> supervision_warnings(const Config& config) {
  using enum controller::Cause;
  constexpr double infinite = std::numeric_limits<double>::infinity();
  std::vector<std::string> warnings;
  for (const AxisConfig& axis : config.axes) {
    if (!controller::feeds_back(axis.control.law.structure)) continue;
    const auto warn_if_off = [&](const Member& key, double limit, double widest, controller::Cause cause) {
      if (limit <= 0.0 || limit >= widest)
        warnings.push_back(fmt::format("axis {}: {} is {:g}, so that `{}` is never detected", axis.wire.name,
                                       key_of(axis, key), limit, controller::to_string(cause)));
    };
    const controller::Supervisor::Config& limits = axis.control.supervision;
    const double plausible_um = limits.position_max_um - limits.position_min_um;
    const double& error_um = axis.control.following_error.error_um;
    warn_if_off(limits.position_jump_um, limits.position_jump_um, plausible_um, position_jumped);
    warn_if_off(error_um, error_um, plausible_um, following_error);
    warn_if_off(limits.frozen_cycles, limits.frozen_cycles, infinite, position_frozen);
    warn_if_off(limits.saturated_s, limits.saturated_s, infinite, saturated);
    warn_if_off(limits.bus_passive_s, limits.bus_passive_s, infinite, bus_passive);
    if (can::message_map<can::AmpStatus>(axis.wire))
      warn_if_off(limits.status_timeout, 1e3 * can::seconds(limits.status_timeout), infinite, status_missing);
  }
  return warnings;
}

std::vector<std::string> findings_of_learning(const AxisConfig& axis, double rate_Hz) {
  constexpr double negligible_cycles = 1e-6;
  controller::AxisConfig control = axis.control;
  const auto designs = controller::plan_learning(control, rate_Hz);
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < designs.size(); ++i) {
    if (!designs[i]) continue;
    const controller::LearningDesign& design = *designs[i];
    std::string line = fmt::format(
        "setpoint[{}]: learning reduces errors up to {:.3g} Hz if the resonance differs from resonance_Hz by "
        "at most {:g} %; each part of the error falls to a tenth within {:.0f} periods "
        "(slowest part: {:.3g} Hz)",
        i, design.highest_Hz, design.resonance_percent, std::ceil(design.slowest_periods), design.slowest_Hz);
    if (design.periods > 1)
      line += fmt::format(
          "; {} periods are learnt as one block of {} cycles: one period is short or not a "
          "whole number of cycles",
          design.periods, design.plan.phases);
    if (design.slip_cycles > negligible_cycles)
      line += fmt::format(
          "; the duration of the learnt {} differs by {:.2f} of a cycle from a whole number of cycles, so "
          "the corrections are interpolated",
          design.periods > 1 ? "block" : "period", design.slip_cycles);
    lines.push_back(line);
  }
  return lines;
}

}  // namespace hystcan::config
