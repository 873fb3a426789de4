#include "app/stage/config_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/stage/dynamics_text.h"
#include "app/stage/frame_roles.h"
#include "config/document/toml_text.h"

namespace hystcan::app {
namespace {

/// `value` with as many significant digits, as TOML.
std::string rounded(double value, int digits = 3) {
  return toml_number(std::stod(fmt::format("{:.{}g}", value, digits)));
}

/// `key = value   # comment`.
std::string key_line(const std::string& key, const std::string& value, const char* comment = "") {
  const std::string text = fmt::format("{:<22} = {}", key, value);
  return *comment == '\0' ? text + "\n" : fmt::format("{:<34} # {}\n", text, comment);
}
std::string quoted(const std::string& key, const std::string& value, const char* comment = "") {
  return key_line(key, config::toml_string(value), comment);
}

std::string heading(const StageFacts& facts) {
  return "# Written by `hystcan init`. `assumed` marks what nobody has stated or measured: look at it.\n"
         "#\n"
         "#   hystcan check FILE         the values in force and their consequences\n"
         "#   hystcan twin FILE          the twin on the bus ...\n"
         "#   hystcan controller FILE    ... and the controller\n"
         "\n[bus]\n" +
         quoted("interface", facts.interface) +
         key_line("bitrate_bit_per_s", fmt::format("{}", facts.bitrate_bit_per_s)) +
         quoted("dbc", facts.dbc) + "\n[controller]\n" + key_line("rate_Hz", toml_number(facts.rate_Hz)) +
         "\n[twin]\n" + key_line("seed", "1") + key_line("heartbeat_ms", "100.0");
}

std::string head_of(const AxisFacts& axis) {
  std::string text = "\n[[axis]]\n" + quoted("name", axis.name);
  if (!axis.message_prefix.empty())
    text += quoted(
        "message_prefix", axis.message_prefix,
        fmt::format("messages {0}AmpCommand, {0}AmpStatus, {0}SensorSample of the DBC", axis.message_prefix)
            .c_str());
  text += quoted("drive_unit", axis.drive_unit) +
          key_line("amplifier_node", fmt::format("{}", axis.amplifier_node)) +
          key_line("sensor_node", fmt::format("{}", axis.sensor_node));
  if (axis.frames) text += frames_text(*axis.frames);
  return text;
}

/// What every drive and every position must keep to.
std::string limits_of(const AxisFacts& axis, double rate_Hz) {
  const std::string& unit = axis.drive_unit;
  const double range = axis.drive_max - axis.drive_min, stroke = axis.travel_um.span();
  // The whole range in some periods of the mode, but not in less than a few cycles.
  const double slew = range * std::min(0.4 * axis.resonance_Hz, 0.2 * rate_Hz);
  const model::Interval position = position_limits_um(axis.travel_um);
  return key_line("drive_min_" + unit, toml_number(axis.drive_min),
                  "no drive beyond these leaves the controller") +
         key_line("drive_max_" + unit, toml_number(axis.drive_max)) +
         key_line("safe_drive_" + unit, toml_number(axis.safe_drive), "where every run ends") +
         key_line("slew_" + unit + "_per_s", rounded(slew, 2),
                  "assumed: the range in 2.5 periods of the resonance") +
         key_line("wipe_slew_" + unit + "_per_s", rounded(std::min(5.0 * range, slew), 2),
                  "ramps in and out; start-up goes to drive_max and back, which erases the stage's memory") +
         key_line("wipe_dwell_s", rounded(std::max(0.1, 20.0 / axis.resonance_Hz))) +
         key_line("position_min_um", rounded(position.lo), "a position beyond these ends the run") +
         key_line("position_max_um", rounded(position.hi)) +
         key_line("position_jump_um", rounded(0.15 * stroke, 2),
                  "in one cycle: more is not possible and shows a loose cable") +
         key_line("following_error_um", rounded(0.15 * stroke, 2), "assumed; structure \"pi\" needs more") +
         key_line("following_error_cycles", "3") + key_line("missing_samples", "3") +
         key_line("repeat", "true");
}

/// An amplifier that does not say when it is enabled is given time for it.
std::string patience_of(const AxisFacts& axis) {
  const bool reports_state = !axis.frames || (axis.frames->status && axis.frames->status->carries("state"));
  return reports_state ? ""
                       : key_line("enable_delay_ms", "500.0",
                                  "assumed: its frames do not say when the amplifier is on");
}

const char* origin_of(const AxisFacts& axis) {
  return axis.mode_is_measured ? "from the step" : "stated, not measured";
}

std::string control_of(const AxisFacts& axis, double rate_Hz) {
  const double omega = 2.0 * std::numbers::pi * axis.resonance_Hz;
  const double ki = std::min(0.5 * axis.damping_ratio * omega, 0.1 * rate_Hz);
  return "\n[axis.control]\n" + quoted("model", axis.model_file) +
         quoted("structure", "inverse+pi", "average, inverse, pi, average+pi, inverse+pi") +
         key_line("kp", "0.0", "um per um") +
         key_line("ki_per_s", rounded(ki),
                  "1/s; `hystcan check` judges the loop, `hystcan tune` proposes others") +
         limits_of(axis, rate_Hz) + patience_of(axis) + "\n[axis.control.delays]\n" +
         key_line("command_delay_us", toml_number(std::round(1e6 / rate_Hz)),
                  "one cycle: the amplifier applies a setpoint at the next SYNC") +
         key_line("amplifier_bandwidth_Hz", rounded(std::max(1000.0, 3.0 * axis.resonance_Hz)),
                  "assumed: no step was recorded") +
         key_line("resonance_Hz", toml_number(axis.resonance_Hz), origin_of(axis)) +
         key_line("damping_ratio", toml_number(axis.damping_ratio),
                  axis.damping_is_assumed ? "assumed" : origin_of(axis)) +
         (axis.sensor_delay_us > 0.0
              ? key_line("sensor_delay_us", toml_number(axis.sensor_delay_us), "stated, not measured")
              : std::string()) +
         "\n[axis.control.in_position]\n" +
         key_line("tolerance_um", rounded(0.002 * axis.travel_um.span(), 2)) + key_line("window_ms", "20.0") +
         key_line("timeout_ms", "2000.0");
}

std::string reference_of(const AxisFacts& axis, double rate_Hz) {
  const auto at = [&](double share) { return rounded(axis.travel_um.lo + share * axis.travel_um.span(), 4); };
  // slower where the resonance is below 200 Hz, or the rate below 500 Hz
  const double slowness = std::max({1.0, 200.0 / axis.resonance_Hz, 500.0 / rate_Hz});
  std::string levels;
  for (const double share : {0.9, 0.15, 0.8, 0.25, 0.7, 0.35, 0.6, 0.45, 0.5})
    levels += (levels.empty() ? "" : ", ") + at(share);
  return "\n[[axis.control.setpoint]]             # 80 % of the travel\n" + quoted("kind", "triangle") +
         key_line("low_um", at(0.1)) + key_line("high_um", at(0.9)) +
         key_line("frequency_Hz", rounded(10.0 / slowness, 2)) + key_line("cycles", "10.0") +
         key_line("transition_s", rounded(0.3 * slowness, 2)) +
         "\n[[axis.control.setpoint]]             # decaying, many levels: the memory keeps every reversal\n" +
         quoted("kind", "staircase") + key_line("levels_um", "[" + levels + "]") +
         key_line("rise_s", rounded(0.05 * slowness, 2)) + key_line("dwell_s", rounded(0.1 * slowness, 2)) +
         key_line("transition_s", rounded(0.2 * slowness, 2));
}

std::string twin_of(const AxisFacts& axis, double rate_Hz) {
  const std::string& unit = axis.drive_unit;
  const double range = axis.drive_max - axis.drive_min;
  return "\n[axis.twin]\n" + quoted("model", axis.plant_file) +
         key_line("resonance_Hz", toml_number(axis.resonance_Hz)) +
         key_line("damping_ratio", toml_number(axis.damping_ratio)) +
         key_line("drive_min_" + unit, rounded(axis.drive_min - 0.2 * range),
                  "assumed: wider than the controller's") +
         key_line("drive_max_" + unit, rounded(axis.drive_max + 0.2 * range)) +
         key_line("safe_drive_" + unit, toml_number(axis.safe_drive)) +
         key_line("slew_" + unit + "_per_s",
                  rounded(4.0 * range * std::min(0.4 * axis.resonance_Hz, 0.2 * rate_Hz), 2), "assumed") +
         key_line("bandwidth_Hz", rounded(std::max(1000.0, 3.0 * axis.resonance_Hz)), "assumed") +
         key_line("command_timeout_ms", rounded(std::max(20.0, 20e3 / rate_Hz), 2)) +
         key_line("noise_um_rms", rounded(axis.noise_um, 2)) +
         key_line("resolution_um", rounded(axis.noise_um / 3.0, 1)) +
         (axis.sensor_delay_us > 0.0
              ? "\n[axis.twin.sensor]\n" + key_line("delay_us", toml_number(axis.sensor_delay_us), "stated")
              : std::string());
}

}  // namespace

model::Interval position_limits_um(const model::Interval& travel_um) {
  const double margin = 0.15 * travel_um.span();
  return {travel_um.lo - margin, travel_um.hi + margin};
}

std::string config_text(const StageFacts& facts) {
  std::string text = heading(facts);
  for (const AxisFacts& axis : facts.axes)
    text += head_of(axis) + control_of(axis, facts.rate_Hz) + reference_of(axis, facts.rate_Hz) +
            twin_of(axis, facts.rate_Hz);
  return text;
}

}  // namespace hystcan::app
