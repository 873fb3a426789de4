// Checks that the keys of a configuration agree with each other. Also computes the findings and warnings that
// `hystcan check` prints for a valid configuration.
//
// If a check fails, it throws Error with the place of the key that conflicts.
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

/// Returns true if an axis can have this name. State files, columns and HDF5 groups contain the name of their
/// axis.
bool is_axis_name(std::string_view name);
inline constexpr const char* expected_axis_name =
    "1 to 64 letters (A to Z, a to z), digits, _, . or -, but not . or .. alone";

/// A configuration to check, and the document from which it was read.
struct Checked {
  const Document& document;
  const Config& config;

  Place place_of(const Member& member) const { return document.place_at(path_of(config, member)); }
  /// Throws Error with the place of the key of this member.
  template <class... Args>
  [[noreturn]] void fail(const Member& member, fmt::format_string<Args...> format, Args&&... args) const {
    throw Error(place_of(member), fmt::format(format, std::forward<Args>(args)...));
  }
};

/// Runs all checks that this header declares: node ids, DBC, units, ranges, delays, bus timing.
void check_agreement(const Checked& checked);

/// Checks the messages of an axis against the DBC: signals, identifiers, overlaps, units and ranges. The
/// messages are the standard messages or the lab's own. If a message or signal is missing, the error lists
/// the most similar names in the DBC.
void check_frames(const Checked& checked, std::size_t axis);
/// Checks that axes that share a message have the same node, the same protection (counter, CRC) and separate
/// signals.
void check_sharing(const Checked& checked);
/// Returns a warning with its remedy for each message that is too long for its CRC: "message M of axis x:
/// ...".
std::vector<std::string> protection_warnings(const Config& config);
/// Returns a warning for each message of more than 8 bytes that the DBC declares as classical CAN.
std::vector<std::string> format_warnings(const Config& config);
/// Returns a warning for each signal of a command message that the controller does not use. The controller
/// always sends the raw value 0 for such a signal; the warning is only given if this is not the physical
/// value 0.
std::vector<std::string> command_warnings(const Config& config);
/// Checks that all messages on the bus have different identifiers. CANopen frames (NMT, heartbeats, SDO) also
/// count as messages.
void check_identifiers(const Checked& checked);
/// Checks the keys of the simulated amplifier and the simulated sensor of an axis, in [axis.twin].
void check_instruments(const Checked& checked, std::size_t axis);
/// Checks [axis.analogue] of all axes. Device names must be valid. Axes may share only interlock inputs and
/// charge pumps. command_timeout_ms must be at least two cycles, and enable_delay_ms at most the time that
/// the controller waits. If the file states the range of an output, the range must include all drives. If the
/// file states the range of a position input, the range must include all setpoints and at least a part of the
/// allowed positions.
void check_analogue(const Checked& checked);
/// Returns a warning for each axis with a sensor range in the file that does not cover the whole stroke.
std::vector<std::string> stroke_warnings(const Config& config);
/// Checks command_delay_us of each axis whose setpoints take effect when the command is received. The delay
/// must be above 0, and at most the worst-case time from a SYNC to the end of the command on the bus.
/// check_bus() must have succeeded before.
void check_receipt_delays(const Checked& checked);
/// Checks that the linear model of the control loop (controller/analysis/linear_loop.h) is stable with the
/// axis's gains and with the plant in [axis.control.delays].
void check_loop(const Checked& checked, std::size_t axis);
/// Checks that the rasters of all axes have the same lines and begin at the same time.
void check_scans(const Checked& checked);
/// Checks the bus timing. Throws Error with the place of rate_Hz if a command can be late, or with the place
/// of background_slots if the slots are wrong, for example if two nodes have the same slot.
void check_bus(const Checked& checked);

/// Designs the filters for the feed-forward and the learning of an axis, if the axis has them. Throws Error
/// if no learning filter is possible for the axis.
void plan_filters(const Document& document, Config& config, std::size_t axis);

/// Assumed error of the resonance frequency, percent. findings_of_loop() warns if the loop has too little
/// margin with this error.
inline constexpr double resonance_off_percent = 10.0;

/// Returns the stability margins of the loop for the configured plant, and the worst margins for a plant
/// whose resonance differs by up to resonance_off_percent.
controller::JudgedLoop judged_loop(const AxisConfig& axis, double rate_Hz);

/// Returns true if the mechanical resonance is so close to a multiple of the cycle rate that setpoints, which
/// change once per cycle, excite it (see controller/control/delays.h).
bool rings_at(const AxisConfig& axis, double rate_Hz);

struct Finding {
  bool is_warning = false;
  std::string text;
};
/// Returns the finding as a line of output: the text, with "warning: " before it if it is a warning.
std::string line_of(const Finding& finding);

/// Returns a warning if the mechanical resonance is close to a multiple of the cycle rate (see rings_at());
/// else returns an empty list.
std::vector<Finding> findings_of_rate(const AxisConfig& axis, double rate_Hz);

/// Returns findings about the control loop: margins, sensitivity and bandwidth. A finding is a warning if the
/// loop has little or no margin with a resonance that differs by resonance_off_percent.
std::vector<Finding> findings_of_loop(const AxisConfig& axis, double rate_Hz);

/// Returns a warning for each supervision that is disabled, for axes with feedback. A supervision is disabled
/// if its limit is 0, or so wide that a plausible position never exceeds the limit.
std::vector<std::string> supervision_warnings(const Config& config);

/// Returns a line of `hystcan check` for each segment in which the controller learns to reduce the periodic
/// error. The line has the highest frequency at which learning reduces the error, and the number of periods
/// in which the error falls to a tenth.
std::vector<std::string> findings_of_learning(const AxisConfig& axis, double rate_Hz);

}  // namespace hystcan::config
