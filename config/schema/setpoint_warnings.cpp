#include "config/schema/setpoint_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "model/hysteresis.h"
#include "model/output_creep.h"

namespace hystcan::config {
namespace {

/// What one segment of the reference demands from the axis: positions, slew of the drive, jumps.
struct SegmentNeeds {
  double lowest_um = std::numeric_limits<double>::infinity();
  double highest_um = -std::numeric_limits<double>::infinity();
  double slew_per_s = 0.0;  ///< highest slew of the drive, drive units per second
  double motion_um = 0.0;   ///< largest motion of the reference in one cycle
  double step_um = 0.0;     ///< largest step between two levels
  std::string place{};      ///< place of the segment for messages: "axis x, setpoint[1]"
};

std::vector<SegmentNeeds> needs_of(const controller::AxisConfig& axis, double rate_Hz) {
  constexpr double most_cycles = 2e6;
  controller::AxisConfig once = axis;
  once.repeat = false;
  controller::Trajectory reference = controller::reference_of(once);
  const model::Hysteresis model(axis.law.model);
  auto memory = model.at_upper_threshold();
  model.advance(memory, controller::model_drives(axis.law.model, axis.gate).lo);
  reference.start_from(memory.output);
  const model::OutputCreep creep(axis.law.creep);
  model::OutputCreep::State creep_state = creep.settled(memory.output);

  std::optional<controller::PlantInverse> inverse;
  if (axis.plant_inverse && controller::feeds_forward(axis.law.structure))
    inverse.emplace(*axis.plant_inverse);
  const auto demand_um = [&](double t_s, double value_um) {
    return inverse ? inverse->feed_forward(t_s, 1.0 / rate_Hz,
                                           [&](double at_s) { return reference.value_um(at_s); })
                   : value_um;
  };

  std::vector<SegmentNeeds> needs(axis.setpoint.size());
  const auto cycles = static_cast<std::size_t>(std::min(reference.length_s() * rate_Hz, most_cycles));
  double last_um = memory.output, last_drive = memory.input;
  bool follows_segment = false;  // true if the last cycle was in a segment and not in a transition
  for (std::size_t n = 0; n < cycles; ++n) {
    const double t_s = static_cast<double>(n) / rate_Hz;
    const controller::Trajectory::Point point = reference.at(t_s);
    creep.advance(creep_state, memory.output, 1.0 / rate_Hz);
    const double at_once_um = creep.inverse(creep_state, demand_um(t_s, point.value_um));
    const bool reached = model.reachable(memory).contains(at_once_um);
    model.advance(memory, model.inverse(memory, at_once_um));
    if (!point.in_transition && point.segment < needs.size()) {
      SegmentNeeds& segment = needs[point.segment];
      segment.lowest_um = std::min(segment.lowest_um, point.value_um);
      segment.highest_um = std::max(segment.highest_um, point.value_um);
      const double moved_um = follows_segment ? std::abs(point.value_um - last_um) : 0.0;
      segment.motion_um = std::max(segment.motion_um, moved_um);
      if (point.at_rest)
        segment.step_um = std::max(segment.step_um, moved_um);
      else if (follows_segment && reached)
        segment.slew_per_s = std::max(segment.slew_per_s, rate_Hz * std::abs(memory.input - last_drive));
    }
    follows_segment = !point.in_transition;
    last_um = point.value_um;
    last_drive = memory.input;
  }
  return needs;
}

void warn_of_reach(const AxisConfig& axis, const SegmentNeeds& needs, std::vector<std::string>& warnings) {
  const model::HysteresisParameters& model = axis.control.law.model;
  const controller::Gate::Config& gate = axis.control.gate;
  const model::Interval drives = controller::model_drives(model, gate);
  const model::Interval reach = controller::model_reach_um(model, gate);
  if (needs.lowest_um >= reach.lo && needs.highest_um <= reach.hi) return;
  warnings.push_back(fmt::format(
      "{}: the setpoint covers {:.6g} to {:.6g} um, but the model reaches {:.6g} to {:.6g} um with {:g} to "
      "{:g} {}: the drive will stay at its limit; keep the setpoint within the reach of the model",
      needs.place, needs.lowest_um, needs.highest_um, reach.lo, reach.hi, drives.lo, drives.hi,
      axis.wire.drive_unit));
}

void warn_of_slew(const AxisConfig& axis, const SegmentNeeds& needs, std::vector<std::string>& warnings) {
  if (needs.slew_per_s <= axis.control.gate.slew_per_s) return;
  const std::string& unit = axis.wire.drive_unit;
  warnings.push_back(fmt::format(
      "{}: the drive must change by up to {:.4g} {}/s, but slew_{}_per_s is {:g}; make the reference {:.3g} "
      "times as slow{}",
      needs.place, needs.slew_per_s, unit, unit, axis.control.gate.slew_per_s,
      needs.slew_per_s / axis.control.gate.slew_per_s,
      axis.control.plant_inverse ? ", or its corners smoother (turnaround_percent)" : ""));
}

void warn_of_jump(const AxisConfig& axis, const SegmentNeeds& needs, std::vector<std::string>& warnings) {
  const double jump_um = axis.control.supervision.position_jump_um;
  if (jump_um > 0.0 && needs.motion_um > jump_um)
    warnings.push_back(fmt::format(
        "{}: the reference moves by up to {:.4g} um in a cycle, but position_jump_um is {:g}: if the "
        "stage follows, the fault is `position jumped`; use a slower reference (rise_s of a staircase)",
        needs.place, needs.motion_um, jump_um));
  const controller::FollowingError::Config& following = axis.control.following_error;
  if (needs.step_um > following.error_um)
    warnings.push_back(fmt::format(
        "{}: a step of {:.4g} um, but following_error_um is {:g}: after {} cycles with a larger error, "
        "the axis faults; use smaller steps, or set rise_s",
        needs.place, needs.step_um, following.error_um, following.cycles));
}

/// Returns the highest frequency of a reference shape; 0 if the shape has no frequency.
double highest_frequency_Hz(const controller::Shape& shape) {
  return std::visit(
      [](const auto& s) {
        if constexpr (requires { s.frequency_Hz; }) return s.frequency_Hz;
        if constexpr (requires { s.from_Hz; }) return std::max(s.from_Hz, s.to_Hz);
        return 0.0;
      },
      shape);
}

void warn_of_rate(const controller::Shape& shape, double rate_Hz, const std::string& place,
                  std::vector<std::string>& warnings) {
  constexpr double fewest_cycles = 4.0;  // minimum number of control cycles in a period of the shape
  const double frequency_Hz = highest_frequency_Hz(shape);
  if (rate_Hz < fewest_cycles * frequency_Hz)
    warnings.push_back(fmt::format(
        "{}: {:g} Hz at a rate of {:g} Hz: a period has {:.3g} cycles, so the drive cannot follow the "
        "reference, and the samples do not show the error; use at most {:g} Hz",
        place, frequency_Hz, rate_Hz, rate_Hz / frequency_Hz, rate_Hz / fewest_cycles));
}

/// Adds a warning if the drive range of the axis extends far beyond the range of the model or of the twin.
/// Such a range is probably a typing error.
void warn_of_range(const AxisConfig& axis, std::vector<std::string>& warnings) {
  constexpr double far = 0.25;  // allowed excess, as a share of the range of model or twin
  const controller::Gate::Config& gate = axis.control.gate;
  const twin::Amplifier::Config& amplifier = axis.twin.plant.amplifier;
  const auto warn = [&](const char* whose, double min, double max) {
    const double beyond = std::max(min - gate.drive_min, gate.drive_max - max);
    if (beyond > far * (max - min))
      warnings.push_back(fmt::format(
          "axis {}: the drive range, {:g} to {:g} {}, extends far beyond the {} range, {:g} to {:g} {}: "
          "check drive_min and drive_max",
          axis.wire.name, gate.drive_min, gate.drive_max, axis.wire.drive_unit, whose, min, max,
          axis.wire.drive_unit));
  };
  const model::Interval& known = axis.control.law.model.input_range();
  warn("model's", known.lo, known.hi);
  warn("twin's", amplifier.drive_min, amplifier.drive_max);
}

}  // namespace

std::vector<std::string> setpoint_warnings(const Config& config) {
  std::vector<std::string> warnings;
  for (const AxisConfig& axis : config.axes) {
    warn_of_range(axis, warnings);
    std::vector<SegmentNeeds> needs = needs_of(axis.control, config.controller.rate_Hz);
    for (std::size_t i = 0; i < needs.size(); ++i) {
      needs[i].place = fmt::format("axis {}, setpoint[{}]", axis.wire.name, i);
      warn_of_rate(axis.control.setpoint[i].shape, config.controller.rate_Hz, needs[i].place, warnings);
      warn_of_reach(axis, needs[i], warnings);
      warn_of_slew(axis, needs[i], warnings);
      warn_of_jump(axis, needs[i], warnings);
    }
  }
  return warnings;
}

}  // namespace hystcan::config
