// The keys of a configuration: one `visit` for each struct, to read, write and describe it. A test compares
// the descriptions of the keys with docs/configuration/*.md. Links in the descriptions start at that folder.
#pragma once

#include <string>
#include <tuple>

#include "config/document/document.h"
#include "config/schema/analogue_schema.h"
#include "config/schema/frames.h"
#include "config/schema/twin_schema.h"

namespace hystcan::config {

template <class V>
void visit(V& v, BusConfig& bus) {
  v.required("interface", bus.interface, any,
             {"CAN interface of `controller` and `twin`; `--interface` overrides it"});
  v.required("bitrate_bit_per_s", bus.bitrate_bit_per_s, {.lo = 10'000, .hi = 1'000'000},
             {"nominal bit rate of the interface and of the simulated bus; the check of the bus also uses "
              "this value"});
  v.optional(
      "data_bitrate_bit_per_s", bus.data_bitrate_bit_per_s, {.lo = 0, .hi = 8'000'000},
      {"CAN FD bit rate of the data phase, on the interface and on the simulated bus; 0: CAN FD frames do "
       "not switch the bit rate"});
  v.required("dbc", bus.dbc, any, {"the CAN database"});
  v.optional("turnaround_us", bus.turnaround, not_negative,
             {"time from SYNC to sample in the sensor plus time from sample to command in the controller"});
  v.optional(
      "background_slots", bus.background_slots, {.lo = 0, .hi = can::sync_counter_max},
      {"number of cycles in a round of [slots](../protocol/cycle.md#background-slots) for "
       "heartbeats and statuses, a divisor of 240; 0: no slots, so these frames are sent at any time"});
}

/// Keys of [controller.realtime].
template <class V>
void visit(V& v, controller::Realtime& r) {
  v.optional("priority", r.priority, {.lo = 0, .hi = 99},
             {"`SCHED_FIFO` priority; 0: the scheduling class of the program does not change"});
  v.optional(
      "lock_memory", r.lock_memory, any,
      {"locks all memory (`mlockall`) and reserves stack and heap, so that no cycle waits for memory"});
  v.optional("cpus", r.cpus, any, {"processors on which the control thread may run, 0 to 1023; empty: all"});
}

template <class V>
void visit(V& v, controller::CommonConfig& c) {
  v.required("rate_Hz", c.rate_Hz, {.lo = 1.0, .hi = rate_max_Hz},
             {"SYNC rate, and control rate of all axes"});
  v.optional("node", c.node, {.lo = 1, .hi = 127}, {"node id of the controller's own heartbeat"});
  v.optional("heartbeat_ms", c.heartbeat_period, positive,
             {"period of the controller's heartbeat and of its NMT start requests"});
  v.optional(
      "heartbeat_timeout_ms", c.heartbeat_timeout, positive,
      {"time without a heartbeat after which a node is silent; at least two heartbeat periods of the nodes"});
  v.optional("command_deadline_us", c.command_deadline, not_negative,
             {"latest time after SYNC to send a command frame of several axes; 0: nine tenths of the cycle"});
  v.optional("wake_up_warn_us", c.lateness_warn, not_negative,
             {"delay of a SYNC above which the log reports the delay; 0: never"});
  v.optional("wake_up_trip_us", c.lateness_trip, not_negative,
             {"SYNC delay above which every axis in use faults; 0: never"});
  v.optional("start_together", c.start_together, any, {"a ready axis waits until the other axes are ready"});
  v.optional("start_timeout_s", c.start_timeout, not_negative,
             {"longest time for which a ready axis waits for the other axes; then it begins without them"});
  v.optional("control_socket", c.control_socket, any, {"file of the [control socket](../control_socket.md)"});
  v.optional("state_dir", c.state_folder, any, {"folder of the state files; empty: no state is saved"});
  v.optional("black_box_dir", c.black_box.folder, any,
             {"folder of the [black boxes](../deployment.md#the-black-box)"});
  v.optional("black_box_files", c.black_box.files, {.lo = 0, .hi = 10'000},
             {"maximum number of black boxes in `black_box_dir`; 0: no black box is written"});
  v.optional_table("realtime", c.realtime, [](V& sub, auto& value) { visit(sub, value); });
}

template <class V>
void visit(V& v, controller::Hold& s) {
  v.required("level_um", s.level_um, any, {"position of the rest"});
  v.required("duration_s", s.duration_s, positive, {"duration of the rest"});
}
template <class V>
void visit(V& v, controller::Step& s) {
  v.required("from_um", s.from_um, any, {"first level"});
  v.required("to_um", s.to_um, any, {"position after a step"});
  v.required("dwell_s", s.dwell_s, positive, {"rest before, between and after the steps"});
  v.optional("steps", s.steps, {.lo = 1, .hi = 1e6}, {"number of steps, each from one level to the other"});
}
template <class V>
void visit(V& v, controller::Ramp& s) {
  v.required("from_um", s.from_um, any, {"first position"});
  v.required("to_um", s.to_um, any, {"last position"});
  v.required("duration_s", s.duration_s, positive, {"duration of the ramp"});
}
inline constexpr Range turnaround_range{.lo = 0.0, .hi = 50.0};

template <class V, class Periodic>
void visit_periodic(V& v, Periodic& s) {
  v.required("low_um", s.low_um, any, {"lowest position, at which the reference begins"});
  v.required("high_um", s.high_um, any, {"highest position"});
  v.required("frequency_Hz", s.frequency_Hz, positive, {"periods per second"});
  v.required("cycles", s.cycles, {.lo = 0.0, .hi = 1e6, .lo_excluded = true},
             {"number of periods; a fraction is allowed"});
}
template <class V>
void visit(V& v, controller::Triangle& s) {
  visit_periodic(v, s);
  v.optional("turnaround_percent", s.turnaround_percent, turnaround_range,
             {"share of each period for its two [turnarounds](#turnarounds) together; 0: sharp corners"});
}
template <class V>
void visit(V& v, controller::Sine& s) {
  visit_periodic(v, s);
}
template <class V>
void visit(V& v, controller::Chirp& s) {
  v.required("low_um", s.low_um, any, {"lowest position"});
  v.required("high_um", s.high_um, any, {"highest position"});
  v.required("from_Hz", s.from_Hz, positive, {"frequency at the start; it changes linearly"});
  v.required("to_Hz", s.to_Hz, positive, {"frequency at the end"});
  v.required("duration_s", s.duration_s, positive, {"duration of the chirp without its fades"});
  v.optional("fade_s", s.fade_s, positive,
             {"duration of the fade-in from the centre, and of the fade-out to it"});
}
template <class V>
void visit(V& v, controller::MultiSine& s) {
  v.required("centre_um", s.centre_um, any, {"position at which the sum of cosines is zero"});
  v.required("amplitudes_um", s.amplitudes_um, positive, {"amplitude of each cosine"});
  v.required("frequencies_Hz", s.frequencies_Hz, positive, {"frequency of each cosine"});
  v.optional("phases_deg", s.phases_deg, any,
             {"phase of each cosine; empty: Schroeder's phases, which give a low peak"});
  v.required("duration_s", s.duration_s, positive, {"duration of the sum of cosines without its fades"});
  v.optional("fade_s", s.fade_s, positive,
             {"duration of the fade-in from the centre, and of the fade-out to it"});
}
template <class V>
void visit(V& v, controller::Table& s) {
  v.required("file", s.file, any,
             {"CSV file of two or more rows with the columns `time_s` (increasing) and `position_um`"});
}
template <class V>
void visit(V& v, controller::Staircase& s) {
  v.required("levels_um", s.levels_um, any, {"levels in sequence"});
  v.optional("rise_s", s.rise_s, not_negative, {"time to move to a level; 0: a step"});
  v.required("dwell_s", s.dwell_s, positive, {"rest at each level"});
}

template <class V>
void visit(V& v, controller::Raster& s) {
  constexpr Range counted{.lo = 1, .hi = 65'535};
  v.required("role", s.role, any, {"`fast`: the axis along the lines; `slow`: the axis from line to line"});
  v.required("low_um", s.low_um, any,
             {"`fast`: position at one end of a line; `slow`: position of the first line"});
  v.required("high_um", s.high_um, any,
             {"`fast`: end of a line opposite to `low_um`; `slow`: position of the last line"});
  v.required("line_rate_Hz", s.line_rate_Hz, positive, {"lines per second"});
  v.required("lines", s.lines, {.lo = 2, .hi = counted.hi}, {"lines per frame"});
  v.optional("return_lines", s.return_lines, counted,
             {"time for the return to the first line after each frame, as a multiple of the time of a line"});
  v.optional("frames", s.frames, counted, {"number of frames"});
  v.optional("pixels", s.pixels, {.lo = 0, .hi = counted.hi},
             {"number of pixels per line for the column `scan_pixel` of the CSV; 0: pixels are not counted"});
  v.optional("both_directions", s.both_directions, any,
             {"`true`: lines alternate up and down; `false`: all lines up, with a flyback"});
  if (!s.both_directions)
    v.optional("flyback_percent", s.flyback_percent, {.lo = 1.0, .hi = 99.0},
               {"share of the line time for the flyback, if `both_directions` is false"});
  v.optional("slow", s.slow, any, {"whether the slow axis rests on each line or moves at constant speed"});
  v.optional("turnaround_percent", s.turnaround_percent, turnaround_range,
             {"share of the line time for turnarounds (one, or two with flyback); 0: sharp corners"});
}

template <class V>
void visit(V& v, controller::Segment& segment) {
  v.takes_effect(Effect::new_reference);
  std::string kind = to_string(segment.shape);
  v.choice("kind", kind, controller::shape_kinds, {"shape of the segment"});
  v.alternative([&] { segment.shape = controller::shape_of_kind(kind); });
  v.optional("transition_s", segment.transition_s, positive,
             {"duration of the smooth path to the first position; "
              "longer if the limits of the reference require it"});
  std::visit([&](auto& shape) { visit(v, shape); }, segment.shape);
}

template <class V>
void visit(V& v, controller::Delays& d) {
  v.required("command_delay_us", d.command_delay, not_negative,
             {"delay from a SYNC until its command takes effect"});
  v.optional("amplifier_bandwidth_Hz", d.amplifier_bandwidth_Hz, positive,
             {"small-signal bandwidth, -3 dB", "of the model"});  // if missing: value of the model file
  v.optional("resonance_Hz", d.resonance_Hz, positive,
             {"frequency of the first mode of the stage with its load", "of the model"});
  v.optional("damping_ratio", d.damping_ratio, not_negative,
             {"damping ratio of the first mode", "of the model"});
  v.optional("interpolated", d.interpolated, any,
             {"the amplifier ramps linearly to each setpoint within a cycle"});
  v.optional("second_order", d.second_order, any,
             {"`true`: the feed-forward compensates mean and variance of delays; `false`: only the mean"});
  v.optional("plant_inverse", d.plant_inverse, any,
             {"`true`: the feed-forward inverts the plant with its first mode and minimises the error "
              "between samples too"});
  v.optional("sensor_delay_us", d.sensor_delay, {.lo = 0.0, .hi = 100'000.0},
             {"time from a motion of the stage until a sample shows the motion"});
  v.optional("sensor_bandwidth_Hz", d.sensor_bandwidth_Hz, not_negative,
             {"bandwidth of the sensor, -3 dB; 0: not limited"});
}

template <class V>
void visit(V& v, controller::Notch::Config& n) {
  v.required("frequency_Hz", n.frequency_Hz, positive,
             {"frequency of the largest attenuation, less than half of `rate_Hz`"});
  v.required("depth", n.depth, {.lo = 0.0, .hi = 1.0}, {"gain of the notch filter at `frequency_Hz`"});
  v.required("width", n.width, positive,
             {"damping ratio of the denominator of the notch filter: a larger value gives a wider notch"});
}

template <class V>
void visit(V& v, controller::Learning::Config& l) {
  v.required("correction_max_um", l.correction_max_um, positive, {"largest correction"});
  v.optional("rate", l.rate, {.lo = 0.0, .hi = 1.0, .lo_excluded = true},
             {"share of the error that is corrected in one period"});
  v.optional("forget_percent", l.forget_percent, {.lo = 0.0, .hi = 50.0, .lo_excluded = true},
             {"share of the correction that is dropped in one period"});
  v.optional("resonance_percent", l.resonance_percent, {.lo = 0.0, .hi = 50.0},
             {"largest deviation of the resonance from `resonance_Hz` at which learning converges"});
  v.optional("frozen", l.frozen, any, {"keeps the learnt correction and stops learning"});
}

/// Keys of the limits that trip an axis. They are in the table [axis.control].
template <class V>
void visit_supervision(V& v, controller::AxisConfig& c) {
  controller::Supervisor::Config& s = c.supervision;
  v.required("position_min_um", s.position_min_um, any, {"`position implausible`: lowest allowed position"});
  v.required("position_max_um", s.position_max_um, any, {"`position implausible`: highest allowed position"});
  v.optional(
      "position_jump_um", s.position_jump_um, not_negative,
      {"`position jumped`: a sample whose position moves by more per cycle counts as missing; 0: off"});
  v.required("following_error_um", c.following_error.error_um, positive,
             {"`following error`: the axis faults if its error against the reference is larger than this"});
  v.optional("following_error_lag_ms", c.following_error.lag, not_negative,
             {"`following error`: the allowed error grows by the motion of the reference in this time"});
  v.optional("following_error_cycles", c.following_error.cycles, {.lo = 1},
             {"`following error`: the axis faults if the error is too large in this many cycles in a row"});
  v.optional("missing_samples", s.missing_samples, {.lo = 0, .hi = 1000},
             {"`sample missing`: the axis faults if more consecutive samples than this are missing"});
  v.optional("frozen_cycles", s.frozen_cycles, any,
             {"`position frozen`: the axis faults after this many equal samples if its drive moves; 0: off"});
  v.optional("saturated_s", s.saturated_s, not_negative,
             {"`saturated`: the axis faults if range, slew or model limits its drive for longer; 0: off"});
  v.optional("bus_passive_s", s.bus_passive_s, not_negative,
             {"`bus passive`: the axis faults if the interface is error-passive for longer; 0: off"});
  v.optional(
      "status_timeout_ms", s.status_timeout, not_negative,
      {"`status missing`: the axis faults if its last status is older (minimum: 2 `status_every`); 0: off"});
}

template <class V>
void visit(V& v, controller::InPosition::Config& c) {
  v.required("tolerance_um", c.tolerance_um, positive, {"largest error at which the stage is in position"});
  v.required("window_ms", c.window, not_negative,
             {"time for which the error must stay within the tolerance"});
  v.required("timeout_ms", c.timeout, positive,
             {"time after which the positioning fails, at least `window_ms`"});
}

inline constexpr Range enable_delay_range{.lo = 0.0, .hi = 10'000.0};

/// Keys of [axis.control]. An amplifier that does not report its state needs enable_delay_ms. A key whose
/// value is a drive has the drive unit in its name, for example drive_min_V.
template <class V>
void visit_control(V& v, AxisConfig& axis) {
  const std::string& unit = axis.wire.drive_unit;
  controller::AxisConfig& c = axis.control;
  v.takes_effect(Effect::at_once);
  v.optional("model", axis.control_model, any,
             {"model file; `hystcan excite` does not need it", "required",
              Effect::after_restart});  // only load_unmeasured() accepts a file without this key
  v.required("structure", c.law.structure, any, {"control structure: [theory](../theory/control_law.md)"});
  v.required("kp", c.law.pi.kp, not_negative, {"proportional gain"});
  v.required("ki_per_s", c.law.pi.ki_per_s, not_negative, {"integral gain"});
  v.optional("deadband_um", c.law.deadband_um, not_negative, {"deadband of the error at the PI input"});
  v.optional("measurement_filter_Hz", c.law.measurement_filter_Hz, not_negative,
             {"corner frequency of a first-order low pass at the PI input; 0: none"});
  v.required("drive_min_" + unit, c.gate.drive_min, any, {"lowest drive in a command"});
  v.required("drive_max_" + unit, c.gate.drive_max, any,
             {"highest drive in a command, at least `input_max` of the model (its upper threshold)"});
  v.required("safe_drive_" + unit, c.gate.safe_drive, any,
             {"drive of the safe command (Enable 0), for example after a fault", {}, Effect::after_restart});
  v.required("slew_" + unit + "_per_s", c.gate.slew_per_s, positive, {"maximum rate of change of the drive"});
  v.optional("start_up", c.start_up, any,
             {"how the controller gets the actuator's memory at the start", {}, Effect::at_next_start});
  v.required("wipe_slew_" + unit + "_per_s", c.wipe_slew_per_s, positive,
             {"speed of the drive ramps at the start and at the end of a run", {}, Effect::at_next_start});
  v.optional("wipe_dwell_s", c.wipe_dwell_s, not_negative,
             {"rest of the drive at each threshold of the model at the start", {}, Effect::at_next_start});
  v.optional("fault_ramp_" + unit + "_per_s", c.fault_ramp_per_s, not_negative,
             {"speed of the ramp to `safe_drive` after a fault with which "
              "[the drive still works](../safety.md#stopping-without-a-blow); 0: no ramp"});
  if (reports_state(axis.wire))
    v.optional("enable_delay_ms", c.enable_delay, enable_delay_range,
               {"minimum time from Enable until the drive moves; "
                "required if the amplifier does not report its state"});
  else
    v.required("enable_delay_ms", c.enable_delay, enable_delay_range,
               {"minimum time from Enable until the drive moves"});
  v.optional("verify_watchdog", c.verify_watchdog, any,
             {"tests the amplifier's watchdog before the first use"});
  visit_supervision(v, c);
  v.optional("repeat", c.repeat, any, {"the reference repeats", {}, Effect::new_reference});
  v.limit_or_inf("reference_slew_um_per_s", c.reference_limits.slew_um_per_s,
                 c.transition_limits.slew_um_per_s,
                 {"maximum speed of the reference", "see below", Effect::new_reference});
  v.limit_or_inf("reference_acceleration_um_per_s2", c.reference_limits.acceleration_um_per_s2,
                 c.transition_limits.acceleration_um_per_s2,
                 {"maximum acceleration of the reference", "see below", Effect::new_reference});
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.optional_table("notch", c.law.notch, plain);
  v.optional_table("learning", c.learning, plain);
  v.table("delays", c.delays, plain);
  v.optional_table("in_position", c.in_position, plain);
  v.optional_list("coupling", c.couplings, plain);
  v.list(setpoint_key, c.setpoint, plain);
}

template <class V>
void visit_crc(V& v, can::MessageMap& map) {
  v.required("crc", map.crc, any,
             {"name of the CRC signal, which is one whole byte, or two bytes for `CRC-16`; only with "
              "`integrity = \"counter+crc\"`"});
  v.optional("polynomial", map.polynomial, any,
             {"polynomial of the CRC; default `CRC-16` for messages of more than 8 bytes"});
  v.required("crc_covers", map.data_id.kind, any,
             {"value that the CRC covers before the payload: `identifier`, `data_id`, or none (`payload`)"});
  if (map.data_id.kind == can::DataId::Kind::number)
    v.required("data_id", map.data_id.number, any,
               {"number that the CRC covers before the payload; only with `crc_covers = \"data_id\"`"});
}

template <class V>
void visit_integrity(V& v, can::MessageMap& map) {
  v.required("integrity", map.integrity, any, {"protection of the message"});
  if (map.integrity == can::Integrity::none) return;
  v.required("counter", map.counter, any, {"name of the counter signal; not with `integrity = \"none\"`"});
  if (map.integrity == can::Integrity::counter_crc) visit_crc(v, map);
}

template <class Payload, class V>
void visit_frame(V& v, can::MessageMap& map) {
  v.required("message", map.message, any, {"name of the message in the DBC"});
  const auto name = [&](const auto& field) {
    const auto found = map.signals.find(field.role);
    std::string signal = found == map.signals.end() ? std::string() : found->second;
    if (must_be_carried(field.role))
      v.required(field.role, signal, any, {"name of a signal"});
    else
      v.optional(field.role, signal, any, {"name of a signal", "not used"});
    if (!signal.empty()) map.signals[field.role] = signal;
  };
  std::apply([&](const auto&... field) { (name(field), ...); }, Payload::fields());
  if (map.carries("state")) {
    v.optional("state_off", map.states.off, any,
               {"raw values of the state `off`; the nodes of hystcan send the first value"});
    v.optional("state_ready", map.states.ready, any, {"raw values of the state `ready`"});
    v.optional("state_enabled", map.states.enabled, any, {"raw values of the state `enabled`"});
    v.optional("state_fault", map.states.fault, any, {"raw values of the state `fault`"});
  }
  visit_integrity(v, map);
}

/// Keys of [axis.frames.command], [axis.frames.status], [axis.frames.sample]: a lab's own frames (frames.h).
template <class V>
void visit_frames(V& v, can::AxisFrames& frames) {
  v.table("command", frames.command, [](V& sub, auto& map) { visit_frame<can::AmpCommand>(sub, map); });
  v.optional_table("status", frames.status, [](V& sub, auto& map) { visit_frame<can::AmpStatus>(sub, map); });
  v.table("sample", frames.sample, [](V& sub, auto& map) { visit_frame<can::SensorSample>(sub, map); });
}

/// Keys of [[axis.amplifier_setup]], [[axis.sensor_setup]]: an object to write by SDO before the node is
/// started.
template <class V>
void visit(V& v, can::SdoWrite& write) {
  v.required("index", write.object.index, {.lo = 1}, {"index of the object, up to 0xFFFF"});
  v.required("subindex", write.object.subindex, any, {"sub-index of the object, up to 255"});
  v.required("value", write.content.value, any, {"value to write, which must fit into `bytes`"});
  v.required("bytes", write.content.bytes, {.lo = 1, .hi = 4}, {"size of the object"});
}

template <class V>
void visit(V& v, AxisConfig& axis) {
  v.required("name", axis.wire.name, any,
             {"unique name of the axis in logs and files: letters, digits, `_`, `.` and `-`"});
  v.optional("message_prefix", axis.wire.message_prefix, any,
             {"prefix in the names of the standard messages: `X` in `XAmpCommand`",
              "required without `[axis.frames]`"});
  v.required("drive_unit", axis.wire.drive_unit, any, {"unit of the drive, as in the model file"});
  v.required("amplifier_node", axis.wire.amplifier_node, {.lo = 1, .hi = 127},
             {"unique node id of the amplifier"});
  v.required("sensor_node", axis.wire.sensor_node, {.lo = 1, .hi = 127}, {"unique node id of the sensor"});
  v.optional("live_setpoint", axis.live_setpoint, any,
             {"the controller obeys `<Axis>Setpoint` frames: [below](#live_setpoint-positions-over-can)"});
  v.optional("scan_marker", axis.scan_marker, any,
             {"the controller sends `<Axis>ScanMarker` when a line of a `raster` begins: "
              "[below](#scan_marker-the-lines-of-a-scan-over-can)"});
  v.optional("setup_timeout_ms", axis.wire.setup_patience.timeout, {.lo = 1.0, .hi = 60'000.0},
             {"time limit for a node's answer to one SDO request of its set-up"});
  v.optional("setup_attempts", axis.wire.setup_patience.attempts, {.lo = 1, .hi = 100},
             {"maximum number of attempts to write each object, including the first one"});
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.optional_list("amplifier_setup", axis.wire.amplifier_setup, plain);
  v.optional_list("sensor_setup", axis.wire.sensor_setup, plain);
  v.optional_table("frames", axis.wire.frames, [](V& sub, auto& value) { visit_frames(sub, value); });
  v.table(control_key, axis, [](V& sub, AxisConfig& value) { visit_control(sub, value); });
  v.table("twin", axis, [](V& sub, AxisConfig& value) { visit_twin(sub, value); });
  v.optional_table("analogue", axis.analogue, plain);
}

template <class V>
void visit(V& v, RecordConfig& r) {
  v.optional("dir", r.folder, any, {"folder of the runs, relative to the working directory"});
  v.optional("at_start", r.at_start, any,
             {"records from the start; otherwise after `ctl record on` or a click on the page"});
  v.optional("bus_log", r.bus_log, any, {"also records the frames of the interface, in candump format"});
  v.optional("part_MB", r.part_MB, {.lo = 1.0, .hi = 1e5},
             {"maximum size of a part of a run (a CSV file); then the next part begins"});
  v.optional("part_s", r.part_time, {.lo = 1.0, .hi = 1e6},
             {"maximum duration of a part of a run; then the next part begins"});
  v.optional(
      "limit_GB", r.limit_GB, {.lo = 0.01, .hi = 1e6},
      {"maximum size of all runs in the folder; [what is deleted first](../runs.md#when-the-folder-is-full)"});
}

template <class V>
void visit(V& v, Config& config) {
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.table("bus", config.bus, plain);
  v.table("controller", config.controller, plain);
  v.section("record", config.record, plain);
  v.table("twin", config.twin, plain);
  v.list("axis", config.axes, plain);
}

}  // namespace hystcan::config
