// The keys of a configuration: one `visit` for each struct, both to read and to print it.
#pragma once

#include "config/document/document.h"
#include "config/schema/frames.h"
#include "config/schema/twin_schema.h"

namespace hystcan::config {

template <class V>
void visit(V& v, BusConfig& bus) {
  v.required("interface", bus.interface);
  v.required("bitrate_bit_per_s", bus.bitrate_bit_per_s, {.lo = 10'000, .hi = 1'000'000});
  v.required("dbc", bus.dbc);
  v.optional("turnaround_us", bus.turnaround, not_negative);
}

/// [controller.realtime].
template <class V>
void visit(V& v, controller::Realtime& r) {
  v.optional("priority", r.priority, {.lo = 0, .hi = 99});
  v.optional("lock_memory", r.lock_memory);
  v.whole_numbers("cpus", r.cpus);
}

template <class V>
void visit(V& v, controller::CommonConfig& c) {
  v.required("rate_Hz", c.rate_Hz, {.lo = 1.0, .hi = 10'000.0});
  v.optional("node", c.node, {.lo = 1, .hi = 127});
  v.optional("heartbeat_ms", c.heartbeat_period, positive);
  v.optional("heartbeat_timeout_ms", c.heartbeat_timeout, positive);
  v.optional("wake_up_warn_us", c.lateness_warn, not_negative);
  v.optional("wake_up_trip_us", c.lateness_trip, not_negative);
  v.optional("start_together", c.start_together);
  v.optional("start_timeout_s", c.start_timeout, not_negative);
  v.name("control_socket", c.control_socket);
  v.name("state_dir", c.state_folder);
  v.name("black_box_dir", c.black_box.folder);
  v.optional("black_box_files", c.black_box.files, {.lo = 0, .hi = 10'000});
  v.optional_table("realtime", c.realtime, [](V& sub, auto& value) { visit(sub, value); });
}

template <class V>
void visit(V& v, controller::Hold& s) {
  v.required("level_um", s.level_um);
  v.required("duration_s", s.duration_s, positive);
}
template <class V>
void visit(V& v, controller::Step& s) {
  v.required("from_um", s.from_um);
  v.required("to_um", s.to_um);
  v.required("dwell_s", s.dwell_s, positive);
  v.optional("steps", s.steps, {.lo = 1, .hi = 1e6});
}
template <class V>
void visit(V& v, controller::Ramp& s) {
  v.required("from_um", s.from_um);
  v.required("to_um", s.to_um);
  v.required("duration_s", s.duration_s, positive);
}
inline constexpr Range turnaround_range{.lo = 0.0, .hi = 50.0};

template <class V, class Periodic>
void visit_periodic(V& v, Periodic& s) {
  v.required("low_um", s.low_um);
  v.required("high_um", s.high_um);
  v.required("frequency_Hz", s.frequency_Hz, positive);
  v.required("cycles", s.cycles, {.lo = 0.0, .hi = 1e6, .lo_excluded = true});
}
template <class V>
void visit(V& v, controller::Triangle& s) {
  visit_periodic(v, s);
  v.optional("turnaround_percent", s.turnaround_percent, turnaround_range);
}
template <class V>
void visit(V& v, controller::Sine& s) {
  visit_periodic(v, s);
}
template <class V>
void visit(V& v, controller::Chirp& s) {
  v.required("low_um", s.low_um);
  v.required("high_um", s.high_um);
  v.required("from_Hz", s.from_Hz, positive);
  v.required("to_Hz", s.to_Hz, positive);
  v.required("duration_s", s.duration_s, positive);
  v.optional("fade_s", s.fade_s, positive);
}
template <class V>
void visit(V& v, controller::MultiSine& s) {
  v.required("centre_um", s.centre_um);
  v.required("amplitudes_um", s.amplitudes_um, positive);
  v.required("frequencies_Hz", s.frequencies_Hz, positive);
  v.numbers("phases_deg", s.phases_deg);
  v.required("duration_s", s.duration_s, positive);
  v.optional("fade_s", s.fade_s, positive);
}
template <class V>
void visit(V& v, controller::Table& s) {
  v.required("file", s.file);
}
template <class V>
void visit(V& v, controller::Staircase& s) {
  v.required("levels_um", s.levels_um);
  v.optional("rise_s", s.rise_s, not_negative);
  v.required("dwell_s", s.dwell_s, positive);
}

template <class V>
void visit(V& v, controller::Raster& s) {
  constexpr Range counted{.lo = 1, .hi = 65'535};
  v.choice("role", s.role);
  v.required("low_um", s.low_um);
  v.required("high_um", s.high_um);
  v.required("line_rate_Hz", s.line_rate_Hz, positive);
  v.required("lines", s.lines, {.lo = 2, .hi = counted.hi});
  v.optional("return_lines", s.return_lines, counted);
  v.optional("frames", s.frames, counted);
  v.optional("pixels", s.pixels, {.lo = 0, .hi = counted.hi});
  v.optional("both_directions", s.both_directions);
  if (!s.both_directions) v.optional("flyback_percent", s.flyback_percent, {.lo = 1.0, .hi = 99.0});
  v.optional_choice("slow", s.slow);
  v.optional("turnaround_percent", s.turnaround_percent, turnaround_range);
}

template <class V>
void visit(V& v, controller::Segment& segment) {
  std::string kind = to_string(segment.shape);
  v.choice("kind", kind, controller::shape_kinds);
  v.alternative([&] { segment.shape = controller::shape_of_kind(kind); });
  v.optional("transition_s", segment.transition_s, positive);
  std::visit([&](auto& shape) { visit(v, shape); }, segment.shape);
}

template <class V>
void visit(V& v, controller::Delays& d) {
  v.required("command_delay_us", d.command_delay, not_negative);
  v.optional("amplifier_bandwidth_Hz", d.amplifier_bandwidth_Hz,
             positive);  // these three: else of the model file
  v.optional("resonance_Hz", d.resonance_Hz, positive);
  v.optional("damping_ratio", d.damping_ratio, not_negative);
  v.optional("interpolated", d.interpolated);
  v.optional("second_order", d.second_order);
  v.optional("plant_inverse", d.plant_inverse);
  v.optional("sensor_delay_us", d.sensor_delay, {.lo = 0.0, .hi = 100'000.0});
  v.optional("sensor_bandwidth_Hz", d.sensor_bandwidth_Hz, not_negative);
}

template <class V>
void visit(V& v, controller::Notch::Config& n) {
  v.required("frequency_Hz", n.frequency_Hz, positive);
  v.required("depth", n.depth, {.lo = 0.0, .hi = 1.0});
  v.required("width", n.width, positive);
}

template <class V>
void visit(V& v, controller::Learning::Config& l) {
  v.required("correction_max_um", l.correction_max_um, positive);
  v.optional("rate", l.rate, {.lo = 0.0, .hi = 1.0, .lo_excluded = true});
  v.optional("forget_percent", l.forget_percent, {.lo = 0.0, .hi = 50.0, .lo_excluded = true});
  v.optional("resonance_percent", l.resonance_percent, {.lo = 0.0, .hi = 50.0});
  v.optional("frozen", l.frozen);
}

/// The limits that trip an axis, also in [axis.control].
template <class V>
void visit_supervision(V& v, controller::AxisConfig& c) {
  controller::Supervisor::Config& s = c.supervision;
  v.required("position_min_um", s.position_min_um);
  v.required("position_max_um", s.position_max_um);
  v.optional("position_jump_um", s.position_jump_um, not_negative);
  v.required("following_error_um", c.following_error.error_um, positive);
  v.optional("following_error_lag_ms", c.following_error.lag, not_negative);
  v.optional("following_error_cycles", c.following_error.cycles, {.lo = 1});
  v.optional("missing_samples", s.missing_samples, {.lo = 0, .hi = 1000});
  v.optional("frozen_cycles", s.frozen_cycles);
  v.optional("saturated_s", s.saturated_s, not_negative);
  v.optional("bus_passive_s", s.bus_passive_s, not_negative);
  v.optional("status_timeout_ms", s.status_timeout, not_negative);
}

template <class V>
void visit(V& v, model::Coupling& c) {
  v.required("from", c.from);
  v.required("um_per_um", c.um_per_um, {.lo = -0.5, .hi = 0.5});
}

template <class V>
void visit(V& v, controller::InPosition::Config& c) {
  v.required("tolerance_um", c.tolerance_um, positive);
  v.required("window_ms", c.window, not_negative);
  v.required("timeout_ms", c.timeout, positive);
}

inline constexpr Range enable_delay_range{.lo = 0.0, .hi = 10'000.0};

/// [axis.control]. An amplifier that does not report its state needs an enable_delay_ms. The keys of a drive have its unit in their names.
template <class V>
void visit_control(V& v, AxisConfig& axis) {
  const std::string& unit = axis.wire.drive_unit;
  controller::AxisConfig& c = axis.control;
  v.name("model", axis.control_model);  // missing only where a straight line stands for it: config.h
  v.choice("structure", c.law.structure);
  v.required("kp", c.law.pi.kp, not_negative);
  v.required("ki_per_s", c.law.pi.ki_per_s, not_negative);
  v.optional("deadband_um", c.law.deadband_um, not_negative);
  v.optional("measurement_filter_Hz", c.law.measurement_filter_Hz, not_negative);
  v.required("drive_min_" + unit, c.gate.drive_min);
  v.required("drive_max_" + unit, c.gate.drive_max);
  v.required("safe_drive_" + unit, c.gate.safe_drive);
  v.required("slew_" + unit + "_per_s", c.gate.slew_per_s, positive);
  v.optional_choice("start_up", c.start_up);
  v.required("wipe_slew_" + unit + "_per_s", c.wipe_slew_per_s, positive);
  v.optional("wipe_dwell_s", c.wipe_dwell_s, not_negative);
  v.optional("fault_ramp_" + unit + "_per_s", c.fault_ramp_per_s, not_negative);
  if (reports_state(axis.wire))
    v.optional("enable_delay_ms", c.enable_delay, enable_delay_range);
  else
    v.required("enable_delay_ms", c.enable_delay, enable_delay_range);
  v.optional("verify_watchdog", c.verify_watchdog);
  visit_supervision(v, c);
  v.optional("repeat", c.repeat);
  v.limit_or_inf("reference_slew_um_per_s", c.reference_limits.slew_um_per_s,
                 c.transition_limits.slew_um_per_s);
  v.limit_or_inf("reference_acceleration_um_per_s2", c.reference_limits.acceleration_um_per_s2,
                 c.transition_limits.acceleration_um_per_s2);
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.optional_table("notch", c.law.notch, plain);
  v.optional_table("learning", c.learning, plain);
  v.table("delays", c.delays, plain);
  v.optional_table("in_position", c.in_position, plain);
  v.optional_list("coupling", c.couplings, plain);
  v.list("setpoint", c.setpoint, plain);
}

/// [axis.frames.command], [axis.frames.status], [axis.frames.sample]: a lab's own frames (frames.h).
template <class V>
void visit_frames(V& v, can::AxisFrames& frames) {
  v.table("command", frames.command, [](V& sub, auto& map) { visit_frame<can::AmpCommand>(sub, map); });
  v.optional_table("status", frames.status, [](V& sub, auto& map) { visit_frame<can::AmpStatus>(sub, map); });
  v.table("sample", frames.sample, [](V& sub, auto& map) { visit_frame<can::SensorSample>(sub, map); });
}

/// [[axis.amplifier_setup]], [[axis.sensor_setup]]: an object that is written by SDO before the node is
/// started.
template <class V>
void visit(V& v, can::SdoWrite& write) {
  v.required("index", write.object.index, {.lo = 1});
  v.required("subindex", write.object.subindex);
  v.required("value", write.content.value);
  v.required("bytes", write.content.bytes, {.lo = 1, .hi = 4});
}

template <class V>
void visit(V& v, AxisConfig& axis) {
  v.required("name", axis.wire.name);
  v.name("message_prefix", axis.wire.message_prefix);
  v.required("drive_unit", axis.wire.drive_unit);
  v.required("amplifier_node", axis.wire.amplifier_node, {.lo = 1, .hi = 127});
  v.required("sensor_node", axis.wire.sensor_node, {.lo = 1, .hi = 127});
  v.optional("live_setpoint", axis.live_setpoint);
  v.optional("scan_marker", axis.scan_marker);
  v.optional("setup_timeout_ms", axis.wire.setup_patience.timeout, {.lo = 1.0, .hi = 60'000.0});
  v.optional("setup_attempts", axis.wire.setup_patience.attempts, {.lo = 1, .hi = 100});
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.optional_list("amplifier_setup", axis.wire.amplifier_setup, plain);
  v.optional_list("sensor_setup", axis.wire.sensor_setup, plain);
  v.optional_table("frames", axis.wire.frames, [](V& sub, auto& value) { visit_frames(sub, value); });
  v.table("control", axis, [](V& sub, AxisConfig& value) { visit_control(sub, value); });
  v.table("twin", axis, [](V& sub, AxisConfig& value) { visit_twin(sub, value); });
}

template <class V>
void visit(V& v, RecordConfig& r) {
  v.name("dir", r.folder);
  v.optional("at_start", r.at_start);
  v.optional("bus_log", r.bus_log);
  v.optional("hdf5", r.hdf5);
  v.optional("part_MB", r.part_MB, {.lo = 1.0, .hi = 1e5});
  v.optional("part_s", r.part_time, {.lo = 1.0, .hi = 1e6});
  v.optional("limit_GB", r.limit_GB, {.lo = 0.01, .hi = 1e6});
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
