// Checks between the keys of a configuration, and what `hystcan check` finds in one that is sound.
//
// A check throws Error at the key in conflict.
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

/// True if an axis can have this name, for which state files, columns and groups of HDF5 are named.
bool is_axis_name(std::string_view name);
inline constexpr const char* expected_axis_name =
    "letters (A to Z, a to z), digits, _, . and -: 1 to 64 of them, not . or .. alone";

/// A configuration to check, and the document in which its keys stand.
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

/// All checks of this file: node ids, DBC, units, ranges, delays, the timing of the bus.
void check_agreement(const Checked& checked);

/// Messages of an axis, standard or a lab's own, against the DBC: signals, identifiers, overlaps, units and
/// ranges. If a message or signal is missing, the error names the nearest ones of the DBC.
void check_frames(const Checked& checked, std::size_t axis);
/// Axes that share a message have the same node, the same protection and signals of their own.
void check_sharing(const Checked& checked);
/// Where a CRC covers more bytes of a message than it can guard: one line for each message, "message M of
/// axis x: ..., what would do".
std::vector<std::string> protection_warnings(const Config& config);
/// Where the DBC calls a message of more than 8 bytes classical: one line for each.
std::vector<std::string> format_warnings(const Config& config);
/// Where a signal of a command has no role and its raw 0, which is sent, is another value: one line for each.
std::vector<std::string> command_warnings(const Config& config);
/// Two messages that are sent or received, including those of CANopen, do not share an identifier.
void check_identifiers(const Checked& checked);
/// The keys of a twin's amplifier and sensor.
void check_instruments(const Checked& checked, std::size_t axis);
/// The scales of [axis.analogue] are not 0, and no two axes use one channel.
void check_analogue(const Checked& checked);
/// command_delay_us of every axis whose setpoints take effect on receipt: more than 0, and at most the latest
/// end of the command on the bus. The bus must have passed check_bus().
void check_receipt_delays(const Checked& checked);
/// The linear loop (controller/analysis/linear_loop.h) is stable for the delays that the axis itself states.
void check_loop(const Checked& checked, std::size_t axis);
/// The rasters of all axes have the same lines, and begin at the same time of each pass.
void check_scans(const Checked& checked);
/// Throws Error at the key rate_Hz if a command can be late, and at background_slots if nodes share one.
void check_bus(const Checked& checked);

/// Designs the filters of the axis: of its feed-forward and of its learning, where it has them. Throws Error
/// where it cannot learn.
void plan_filters(const Document& document, Config& config, std::size_t axis);

/// The resonance may be this far off: where the loop then has no margin, findings_of_loop() warns.
inline constexpr double resonance_off_percent = 10.0;

/// Margins for the stated plant, and the worst ones with its resonance off.
controller::JudgedLoop judged_loop(const AxisConfig& axis, double rate_Hz);

/// The mode is so near a multiple of the rate that held setpoints ring it (controller/control/delays.h).
bool rings_at(const AxisConfig& axis, double rate_Hz);

struct Finding {
  bool is_warning = false;
  std::string text;
};
/// The line of the finding: "warning: " before the text of a warning.
std::string line_of(const Finding& finding);

/// Warns if the mode is near a multiple of the rate (controller/control/delays.h).
std::vector<Finding> findings_of_rate(const AxisConfig& axis, double rate_Hz);

/// Margins, sensitivity, bandwidth; a warning if the margin is lost with the resonance off.
std::vector<Finding> findings_of_loop(const AxisConfig& axis, double rate_Hz);

/// One line for each supervision of an axis with feedback that is off: its limit is 0, or so wide that a
/// plausible position never exceeds it.
std::vector<std::string> supervision_warnings(const Config& config);

/// Lines for `check`: what the learning learns of each segment, up to which frequency, and how fast.
std::vector<std::string> findings_of_learning(const AxisConfig& axis, double rate_Hz);

}  // namespace hystcan::config
