// The keys of [twin] and [axis.twin]: one `visit` for each struct. config/schema/check.cpp and
// config/schema/check_instruments.h check them against each other.
#pragma once

#include <string>

#include "config/document/document.h"

namespace hystcan::config {

/// Keys of the amplifier's load; they depend on the drive unit, V or A.
template <class V>
void visit_load(V& v, const std::string& unit, twin::Amplifier::Config& amplifier) {
  if (unit == "V") {
    v.limit("current_limit_A", amplifier.current_limit_A);
    v.optional("load_uF", amplifier.load_uF, not_negative);
  } else if (unit == "A") {
    v.limit("voltage_limit_V", amplifier.voltage_limit_V);
    v.optional("load_mH", amplifier.load_mH, not_negative);
  }
  v.optional("load_ohm", amplifier.load_ohm, not_negative);
}

/// Keys of the amplifier other than range, slew and bandwidth.
template <class V>
void visit_amplifier(V& v, const std::string& unit, twin::AxisConfig& t) {
  twin::Amplifier::Config& amplifier = t.plant.amplifier;
  visit_load(v, unit, amplifier);
  v.optional("drive_resolution_" + unit, amplifier.resolution, not_negative);
  v.optional("drive_noise_" + unit + "_per_rtHz", t.drive_noise.density_per_rtHz, not_negative);
  v.optional("ripple_" + unit, t.drive_noise.ripple, not_negative);
  v.optional("ripple_Hz", t.drive_noise.ripple_Hz, not_negative);
  v.optional_choice("watchdog_action", t.watchdog_action);
  v.limit("watchdog_ramp_" + unit + "_per_s", amplifier.ramp_per_s);
  v.optional_choice("apply", t.apply);
  v.optional("interpolate", t.interpolate);
  v.optional("enable_delay_ms", t.enable_delay, {.lo = 0.0, .hi = 10'000.0});
  v.optional("soft_start_ms", t.soft_start, {.lo = 0.0, .hi = 10'000.0});
}

/// [axis.twin.sensor]: keys of the sensor other than white noise and resolution.
template <class V>
void visit_sensor(V& v, twin::AxisConfig& t) {
  twin::Sensor::Config& sensor = t.sensor;
  v.optional("bandwidth_Hz", sensor.bandwidth_Hz, not_negative);
  v.optional("noise_density_um_per_rtHz", sensor.noise_density_um_per_rtHz, not_negative);
  v.optional("delay_us", sensor.delay, {.lo = 0.0, .hi = 100'000.0});
  v.optional("drift_um_per_h", sensor.drift_um_per_h);
  v.optional("gain_error_percent", sensor.gain_error_percent, {.lo = -300.0, .hi = 300.0});  // -200: reversed
  v.optional("offset_um", sensor.offset_um);
  v.optional("nonlinearity_percent", sensor.nonlinearity_percent, {.lo = -10.0, .hi = 10.0});
  v.bound("range_min_um", sensor.range_min_um);
  v.bound("range_max_um", sensor.range_max_um);
  v.optional_choice("sampling", t.sample_clock.sampling);
  v.optional("sample_rate_Hz", t.sample_clock.rate_Hz, {.lo = 0.0, .hi = 10'000.0});
  v.optional("skew_ppm", t.sample_clock.skew_ppm, {.lo = -10'000.0, .hi = 10'000.0});
}

/// [axis.twin.second_mode], [axis.twin.creep], [axis.twin.temperature], [[axis.twin.coupling]].
template <class V>
void visit(V& v, twin::SecondMode& second) {
  v.required("resonance_Hz", second.mode.natural_frequency_Hz, positive);
  v.required("damping_ratio", second.mode.damping_ratio, not_negative);
  v.required("share", second.share, {.lo = 0.0, .hi = 1.0});
}
template <class V>
void visit(V& v, twin::LogarithmicCreep& creep) {
  v.required("per_decade", creep.per_decade, {.lo = -0.1, .hi = 0.1});
  v.required("from_s", creep.from_s, positive);
  v.required("to_s", creep.to_s, positive);
}
template <class V>
void visit(V& v, twin::Temperature& temperature) {
  v.required("swing_K", temperature.swing_K, not_negative);
  v.required("period_s", temperature.period_s, positive);
  v.required("expansion_um_per_K", temperature.expansion_um_per_K);
  v.required("gain_per_K", temperature.gain_per_K);
}

/// [axis.twin]: the physical axis.
template <class V>
void visit_twin(V& v, AxisConfig& axis) {
  const std::string& unit = axis.wire.drive_unit;
  twin::AxisConfig& t = axis.twin;
  v.name("model", axis.twin_model);  // as in [axis.control]
  v.optional("resonance_Hz", t.plant.mode.natural_frequency_Hz,
             positive);  // and bandwidth_Hz: else of the model file
  v.optional("damping_ratio", t.plant.mode.damping_ratio, not_negative);
  v.required("drive_min_" + unit, t.plant.amplifier.drive_min);
  v.required("drive_max_" + unit, t.plant.amplifier.drive_max);
  v.required("safe_drive_" + unit, t.plant.amplifier.safe_drive);
  v.required("slew_" + unit + "_per_s", t.plant.amplifier.slew_per_s, positive);
  v.optional("bandwidth_Hz", t.plant.amplifier.bandwidth_Hz, positive);
  v.required("command_timeout_ms", t.command_timeout, positive);
  v.optional("status_every", t.status_every, {.lo = 1, .hi = 1000});
  v.required("noise_um_rms", t.sensor.noise_um_rms, not_negative);
  v.required("resolution_um", t.sensor.resolution_um, not_negative);
  v.optional("substep_us", t.plant.substep, {.lo = 1.0, .hi = 1000.0});
  visit_amplifier(v, unit, t);
  v.section("sensor", t, [](V& sub, twin::AxisConfig& value) { visit_sensor(sub, value); });
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.optional_table("second_mode", t.plant.second_mode, plain);
  v.optional_table("creep", t.plant.creep, plain);
  v.optional_table("temperature", t.plant.temperature, plain);
  v.optional_list("coupling", t.couplings, plain);
}

/// [[twin.fault]]. The keys depend on the kind.
template <class V>
void visit(V& v, twin::FaultSpec& f) {
  v.choice("kind", f.kind);
  v.alternative([&] { f = twin::fault_spec(f.kind, f.axis); });
  const twin::FaultTraits& its = twin::traits(f.kind);
  v.required("axis", f.axis);
  if (its.site != twin::FaultSite::plant) v.optional_choice("node", f.node);
  v.required("at_s", f.begins, not_negative);
  v.required("duration_s", f.lasts, positive);
  if (!its.unit.empty()) v.optional("value", f.value, {.lo = its.lowest, .hi = its.highest});
  v.optional("repeat_every_s", f.repeat_every, not_negative);
}

/// [twin.random_faults].
template <class V>
void visit(V& v, twin::RandomFaults& r) {
  v.optional("seed", r.seed);
  v.required("rate_per_hour", r.rate_per_hour, {.lo = 0.0, .hi = 36'000.0, .lo_excluded = true});
  v.optional("duration_min_s", r.shortest, positive);
  v.optional("duration_max_s", r.longest, positive);
  v.choices("kinds", r.kinds);
}

template <class V>
void visit(V& v, twin::CommonConfig& t) {
  v.optional("seed", t.seed);
  v.required("heartbeat_ms", t.heartbeat_period, positive);
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.optional_list("fault", t.faults, plain);
  v.optional_table("random_faults", t.random_faults, plain);
}

}  // namespace hystcan::config
