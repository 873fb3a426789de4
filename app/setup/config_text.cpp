#include "app/setup/config_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/report/dynamics_text.h"
#include "app/setup/frame_roles.h"
#include "config/document/toml_text.h"

namespace hystcan::app {
namespace {

/// `value` with as many significant digits, as TOML.
std::string rounded(double value, int digits = 3) {
  return toml_number(std::stod(fmt::format("{:.{}g}", value, digits)));
}

/// `key = value   # comment`.
std::string line(const std::string& key, const std::string& value, const char* comment = "") {
  const std::string text = fmt::format("{:<22} = {}", key, value);
  return *comment == '\0' ? text + "\n" : fmt::format("{:<34} # {}\n", text, comment);
}
std::string quoted(const std::string& key, const std::string& value, const char* comment = "") {
  return line(key, config::toml_string(value), comment);
}

std::string heading(const StageFacts& facts) {
  return "# Written by `hystcan init`. `assumed` marks what nobody has stated or measured: look at it.\n"
         "#\n"
         "#   hystcan check FILE         the values in force and their consequences\n"
         "#   hystcan twin FILE          the twin on the bus ...\n"
         "#   hystcan controller FILE    ... and the controller\n"
         "\n[bus]\n" +
         quoted("interface", facts.interface) +
         line("bitrate_bit_per_s", fmt::format("{}", facts.bitrate_bit_per_s)) + quoted("dbc", facts.dbc) +
         "\n[controller]\n" + line("rate_Hz", toml_number(facts.rate_Hz)) + "\n[twin]\n" + line("seed", "1") +
         line("heartbeat_ms", "100.0");
}

std::string head_of(const AxisFacts& axis) {
  std::string text = "\n[[axis]]\n" + quoted("name", axis.name);
  if (!axis.message_prefix.empty())
    text += quoted(
        "message_prefix", axis.message_prefix,
        fmt::format("messages {0}AmpCommand, {0}AmpStatus, {0}SensorSample of the DBC", axis.message_prefix)
            .c_str());
  text += quoted("drive_unit", axis.drive_unit) +
          line("amplifier_node", fmt::format("{}", axis.amplifier_node)) +
          line("sensor_node", fmt::format("{}", axis.sensor_node));
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
  return line("drive_min_" + unit, toml_number(axis.drive_min),
              "no drive beyond these leaves the controller") +
         line("drive_max_" + unit, toml_number(axis.drive_max)) +
         line("safe_drive_" + unit, toml_number(axis.safe_drive), "where every run ends") +
         line("slew_" + unit + "_per_s", rounded(slew, 2),
              "assumed: the range in 2.5 periods of the resonance") +
         line("wipe_slew_" + unit + "_per_s", rounded(std::min(5.0 * range, slew), 2),
              "ramps in and out; start-up goes to drive_max and back, which erases the stage's memory") +
         line("wipe_dwell_s", rounded(std::max(0.1, 20.0 / axis.resonance_Hz))) +
         line("position_min_um", rounded(position.lo), "a position beyond these ends the run") +
         line("position_max_um", rounded(position.hi)) +
         line("position_jump_um", rounded(0.15 * stroke, 2),
              "in one cycle: more is not possible and shows a loose cable") +
         line("following_error_um", rounded(0.15 * stroke, 2), "assumed; structure \"pi\" needs more") +
         line("following_error_cycles", "3") + line("missing_samples", "3") + line("repeat", "true");
}

/// An amplifier that does not say when it is enabled is given time for it.
std::string patience_of(const AxisFacts& axis) {
  const bool reports_state = !axis.frames || (axis.frames->status && axis.frames->status->carries("state"));
  return reports_state
             ? ""
             : line("enable_delay_ms", "500.0", "assumed: its frames do not say when the amplifier is on");
}

const char* origin_of(const AxisFacts& axis) {
  return axis.mode_is_measured ? "from the step" : "stated, not measured";
}

std::string control_of(const AxisFacts& axis, double rate_Hz) {
  const double omega = 2.0 * std::numbers::pi * axis.resonance_Hz;
  const double ki = std::min(0.5 * axis.damping_ratio * omega, 0.1 * rate_Hz);
  return "\n[axis.control]\n" + quoted("model", axis.model_file) +
         quoted("structure", "inverse+pi", "average, inverse, pi, average+pi, inverse+pi") +
         line("kp", "0.0", "um per um") +
         line("ki_per_s", rounded(ki),
              "1/s; `hystcan check` judges the loop, `hystcan tune` proposes others") +
         limits_of(axis, rate_Hz) + patience_of(axis) + "\n[axis.control.delays]\n" +
         line("command_delay_us", toml_number(std::round(1e6 / rate_Hz)),
              "one cycle: the amplifier applies a setpoint at the next SYNC") +
         line("amplifier_bandwidth_Hz", rounded(std::max(1000.0, 3.0 * axis.resonance_Hz)),
              "assumed: no step was recorded") +
         line("resonance_Hz", toml_number(axis.resonance_Hz), origin_of(axis)) +
         line("damping_ratio", toml_number(axis.damping_ratio),
              axis.damping_is_assumed ? "assumed" : origin_of(axis)) +
         (axis.sensor_delay_us > 0.0
              ? line("sensor_delay_us", toml_number(axis.sensor_delay_us), "stated, not measured")
              : std::string()) +
         "\n[axis.control.in_position]\n" + line("tolerance_um", rounded(0.002 * axis.travel_um.span(), 2)) +
         line("window_ms", "20.0") + line("timeout_ms", "2000.0");
}

std::string reference_of(const AxisFacts& axis, double rate_Hz) {
  const auto at = [&](double share) { return rounded(axis.travel_um.lo + share * axis.travel_um.span(), 4); };
  // slower where the resonance is below 200 Hz, or the rate below 500 Hz
  const double slowness = std::max({1.0, 200.0 / axis.resonance_Hz, 500.0 / rate_Hz});
  std::string levels;
  for (const double share : {0.9, 0.15, 0.8, 0.25, 0.7, 0.35, 0.6, 0.45, 0.5})
    levels += (levels.empty() ? "" : ", ") + at(share);
  return "\n[[axis.control.setpoint]]             # 80 % of the travel\n" + quoted("kind", "triangle") +
         line("low_um", at(0.1)) + line("high_um", at(0.9)) +
         line("frequency_Hz", rounded(10.0 / slowness, 2)) + line("cycles", "10.0") +
         line("transition_s", rounded(0.3 * slowness, 2)) +
         "\n[[axis.control.setpoint]]             # decaying, many levels: the memory keeps every reversal\n" +
         quoted("kind", "staircase") + line("levels_um", "[" + levels + "]") +
         line("rise_s", rounded(0.05 * slowness, 2)) + line("dwell_s", rounded(0.1 * slowness, 2)) +
         line("transition_s", rounded(0.2 * slowness, 2));
}

std::string twin_of(const AxisFacts& axis, double rate_Hz) {
  const std::string& unit = axis.drive_unit;
  const double range = axis.drive_max - axis.drive_min;
  return "\n[axis.twin]\n" + quoted("model", axis.plant_file) +
         line("resonance_Hz", toml_number(axis.resonance_Hz)) +
         line("damping_ratio", toml_number(axis.damping_ratio)) +
         line("drive_min_" + unit, rounded(axis.drive_min - 0.2 * range),
              "assumed: wider than the controller's") +
         line("drive_max_" + unit, rounded(axis.drive_max + 0.2 * range)) +
         line("safe_drive_" + unit, toml_number(axis.safe_drive)) +
         line("slew_" + unit + "_per_s",
              rounded(4.0 * range * std::min(0.4 * axis.resonance_Hz, 0.2 * rate_Hz), 2), "assumed") +
         line("bandwidth_Hz", rounded(std::max(1000.0, 3.0 * axis.resonance_Hz)), "assumed") +
         line("command_timeout_ms", rounded(std::max(20.0, 20e3 / rate_Hz), 2)) +
         line("noise_um_rms", rounded(axis.noise_um, 2)) +
         line("resolution_um", rounded(axis.noise_um / 3.0, 1)) +
         (axis.sensor_delay_us > 0.0
              ? "\n[axis.twin.sensor]\n" + line("delay_us", toml_number(axis.sensor_delay_us), "stated")
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
