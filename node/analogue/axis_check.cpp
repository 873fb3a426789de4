#include "node/analogue/axis_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hystcan::node {
namespace {

/// Returns the tolerance of a comparison with the limits of `span`. Rounding can move a product that is
/// exactly at a limit to the other side of the limit.
double rounding_of(const Span& span) { return 1e-9 * (std::abs(span.lo) + std::abs(span.hi)); }

/// Returns the positions that the input can measure, between the ends of its range.
Span measured(const AnalogueConfig& config, const VoltageRange& input) {
  const double at_lo = config.position_um(input.lo + input.step);
  const double at_hi = config.position_um(input.hi - input.step);
  return {std::min(at_lo, at_hi), std::max(at_lo, at_hi)};
}

bool contains(const Span& outer, const Span& inner) {
  const double rounding = rounding_of(outer);
  return inner.lo >= outer.lo - rounding && inner.hi <= outer.hi + rounding;
}

/// Returns the range as text, for example "0 to 10". `range` is a Span or a VoltageRange.
std::string text_of(const auto& range) { return from_to(range.lo, range.hi); }

/// Returns the key for an error about the input range: the key that the user will most likely have to change.
std::string_view key_of_input(const AnalogueConfig& config) {
  return config.position_input.place.range.empty() ? "position_um_per_V" : "position_input.range";
}

}  // namespace

void check_drives(const AnalogueConfig& config, const DriveRange& drives, const VoltageRange& output) {
  for (const double drive : {drives.min, drives.max, drives.safe}) {
    const double volts = config.volts_per_drive * drive + 0.0;  // + 0.0 turns -0.0 into 0.0
    if (!contains({output.lo, output.hi}, {volts, volts}))
      throw ChannelError(
          "volts_per_drive",
          Error(fmt::format("a drive of {:g} needs {:g} V, but the range of the output is {} V", drive, volts,
                            text_of(output)),
                {.remedy = "choose a larger range of drive_output, or limit the drive in [axis.control]"}));
  }
}

void check_positions(const AnalogueConfig& config, const PositionRange& positions,
                     const VoltageRange& input) {
  const Span sensor = measured(config, input);
  const auto fail = [&](const std::string& what) {
    throw ChannelError(
        key_of_input(config),
        Error(
            fmt::format("the input range {} V measures {} um, but {}", text_of(input), text_of(sensor), what),
            {.remedy = "correct position_um_per_V and position_zero_um, or choose another range of "
                       "position_input"}));
  };
  if (sensor.hi < positions.limits.lo || sensor.lo > positions.limits.hi)
    fail(fmt::format("position_min_um and position_max_um allow {} um", text_of(positions.limits)));
  if (!contains(sensor, positions.setpoint))
    fail(fmt::format("the setpoints range from {} um", text_of(positions.setpoint)));
}

std::string stroke_warning(const AnalogueConfig& config, const PositionRange& positions,
                           const VoltageRange& input) {
  const Span sensor = measured(config, input);
  if (contains(sensor, positions.stroke)) return {};
  return fmt::format(
      "the input range {} V measures {} um, but the stroke is {} um; a start-up with a wipe (drive up to "
      "drive_max and down) will end with the fault `sensor status`",
      text_of(input), text_of(sensor), text_of(positions.stroke));
}

VoltageRange check_channels(const WiredAnalogueAxis& axis, Card& card) {
  const AnalogueConfig& config = axis.config;
  const VoltageRange output = opened("drive_output", [&] { return card.check_output(config.drive_output); });
  const auto check_line = [](const char* key, const std::optional<LineConfig>& line, const auto& check) {
    if (line) opened(key, [&] { check(line->place); });
  };
  const auto drives = [&](const CardChannel& place) { card.check_line_output(place); };
  check_line("enable_line", config.enable_line, drives);
  check_line("charge_pump_line", config.charge_pump_line, drives);
  check_line("interlock_line", config.interlock_line,
             [&](const CardChannel& place) { card.check_line_input(place); });
  check_drives(config, axis.drives, output);
  return output;
}

}  // namespace hystcan::node
