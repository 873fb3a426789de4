// Checks between the keys of a configuration, and the findings of `hystcan check` in a valid configuration.
//
// A check throws Error at the conflicting key.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "config/document/document.h"
#include "config/schema/settings.h"
#include "controller/analysis/loop_design.h"

namespace hystcan::config {

/// Returns true if an axis can have this name; state files, columns and HDF5 groups have it in their names.
bool is_axis_name(std::string_view name);
inline constexpr const char* expected_axis_name =
    "letters (A to Z, a to z), digits, _, . and -: 1 to 64 of them, not . or .. alone";

/// A configuration to check, and the document that contains its keys.
struct Checked {
  const Document& document;
  const Config& config;

  Place place_of(const Member& member) const { return document.place_at(path_of(config, member)); }
  /// Throws Error at the key of this member.
  template <class... Args>
  [[noreturn]] void fail(const Member& member, fmt::format_string<Args...> format, Args&&... args) const {
    throw Error(place_of(member), fmt::format(format, std::forward<Args>(args)...));
  }
};

/// Runs all checks of this file: node ids, DBC, units, ranges, delays, bus timing.
void check_agreement(const Checked& checked);

/// Checks the messages of an axis, standard or the lab's own, against the DBC: signals, identifiers,
/// overlaps, units and ranges. If a message or signal is missing, the error lists the most similar names in
/// the DBC.
void check_frames(const Checked& checked, std::size_t axis);
/// Checks that axes with a common message have the same node, the same protection and separate signals.
void check_sharing(const Checked& checked);
/// Returns one line for each message that is too long for its CRC: "message M of axis x: ...", with the
/// remedy.
std::vector<std::string> protection_warnings(const Config& config);
/// Returns one line for each message of more than 8 bytes that the DBC declares as classical CAN.
std::vector<std::string> format_warnings(const Config& config);
/// Returns one line for each signal that has no role in the command and whose raw value 0, which is always
/// sent, is not the physical value 0.
std::vector<std::string> command_warnings(const Config& config);
/// Checks that no two messages that are sent or received, CANopen frames included, share an identifier.
void check_identifiers(const Checked& checked);
/// Checks the keys of a twin's amplifier and sensor.
void check_instruments(const Checked& checked, std::size_t axis);
/// Checks [axis.analogue]: devices have valid names, axes share only interlock inputs and charge pumps, times
/// agree with those of the controller, and stated ranges cover the drives, the setpoints and a part of the
/// positions.
void check_analogue(const Checked& checked);
/// Returns one line for each axis whose stated sensor range does not cover the whole stroke.
std::vector<std::string> stroke_warnings(const Config& config);
/// Checks command_delay_us of every axis whose setpoints take effect on receipt: above 0, and at most the
/// latest end of the command on the bus. Call check_bus() first.
void check_receipt_delays(const Checked& checked);
/// Checks that the linear loop (controller/analysis/linear_loop.h) is stable with the delays of the axis's
/// own keys.
void check_loop(const Checked& checked, std::size_t axis);
/// Checks that the rasters of all axes have the same lines and begin at the same time of each pass.
void check_scans(const Checked& checked);
/// Throws Error at the key rate_Hz if a command can be late, and at background_slots if nodes share a slot.
void check_bus(const Checked& checked);

/// Designs the filters of the axis, for its feed-forward and its learning, if it has them. Throws Error if
/// learning is impossible.
void plan_filters(const Document& document, Config& config, std::size_t axis);

/// Assumed error of the resonance; findings_of_loop() warns if the loop has no margin with this error.
inline constexpr double resonance_off_percent = 10.0;

/// Returns the margins for the configured plant, and the worst ones with its resonance off by
/// resonance_off_percent.
controller::JudgedLoop judged_loop(const AxisConfig& axis, double rate_Hz);

/// Returns true if the mode is so close to a multiple of the rate that held setpoints excite it
/// (controller/control/delays.h).
bool rings_at(const AxisConfig& axis, double rate_Hz);

struct Finding {
  bool is_warning = false;
  std::string text;
};
/// Returns the line of the finding: "warning: " before the text of a warning.
std::string line_of(const Finding& finding);

/// Warns if the mode is close to a multiple of the rate (controller/control/delays.h).
std::vector<Finding> findings_of_rate(const AxisConfig& axis, double rate_Hz);

/// Returns margins, sensitivity and bandwidth; warns if no margin is left with the resonance off
/// by resonance_off_percent.
std::vector<Finding> findings_of_loop(const AxisConfig& axis, double rate_Hz);

/// Returns one line for each disabled supervision of an axis with feedback: its limit is 0, or so wide that a
/// plausible position never exceeds it.
std::vector<std::string> supervision_warnings(const Config& config);

/// Returns lines for `check`: for each segment, the learnt part, the highest frequency and the speed of
/// learning.
std::vector<std::string> findings_of_learning(const AxisConfig& axis, double rate_Hz);

}  // namespace hystcan::config
