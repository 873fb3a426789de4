// The keys of the configuration tables [twin] and [axis.twin]. A function `visit` lists the keys of each
// struct. config/schema/check.h checks that the keys agree with each other.
#pragma once

#include <string>

#include "config/document/document.h"

namespace hystcan::config {

/// Lists the keys of [[axis.control.coupling]] and [[axis.twin.coupling]].
template <class V>
void visit(V& v, model::Coupling& c) {
  v.required("from", c.from, any, {"axis whose motion also moves this axis"});
  v.required("um_per_um", c.um_per_um, {.lo = -0.5, .hi = 0.5},
             {"position added to this axis per um of the other axis"});
}

/// Placeholder for the drive unit, V or A, in the description of the keys for the documentation.
inline constexpr std::string_view any_drive_unit = "<U>";

/// Lists the keys of the amplifier's load. They depend on the drive unit, V or A.
template <class V>
void visit_load(V& v, const std::string& unit, twin::Amplifier::Config& amplifier) {
  if (unit == "V" || unit == any_drive_unit) {
    v.optional("current_limit_A", amplifier.current_limit_A, positive,
               {"limit of the current into `load_uF` if the drive is in V", "unlimited"});
    v.optional("load_uF", amplifier.load_uF, not_negative,
               {"capacitance of the load if the drive is in V; 0: no capacitance"});
  }
  if (unit == "A" || unit == any_drive_unit) {
    v.optional("voltage_limit_V", amplifier.voltage_limit_V, positive,
               {"voltage limit across `load_mH` and `load_ohm` if the drive is in A", "unlimited"});
    v.optional("load_mH", amplifier.load_mH, not_negative,
               {"inductance of the coil if the drive is in A; 0: no inductance"});
  }
  v.optional("load_ohm", amplifier.load_ohm, not_negative,
             {"drive in V: resistance across `load_uF`; drive in A: resistance of the coil"});
}

/// Lists the keys of the simulated amplifier, except range, slew and bandwidth (see visit_twin()).
template <class V>
void visit_amplifier(V& v, const std::string& unit, twin::AxisConfig& t) {
  twin::Amplifier::Config& amplifier = t.plant.amplifier;
  visit_load(v, unit, amplifier);
  v.optional("drive_resolution_" + unit, amplifier.resolution, not_negative,
             {"size of the least significant bit of the converter; 0: not quantised"});
  v.optional("drive_noise_" + unit + "_per_rtHz", t.drive_noise.density_per_rtHz, not_negative,
             {"one-sided density of the white noise at the output"});
  v.optional("ripple_" + unit, t.drive_noise.ripple, not_negative, {"amplitude of a sine on the output"});
  v.optional("ripple_Hz", t.drive_noise.ripple_Hz, not_negative,
             {"frequency of the sine on the output, at most 1 / (2 `substep_us`)"});
  v.optional("watchdog_action", t.watchdog_action, any, {"reaction of the output when commands stop"});
  v.optional(
      "watchdog_ramp_" + unit + "_per_s", amplifier.ramp_per_s, positive,
      {"speed of the output after the watchdog has tripped; the slew limit or the load can make it slower",
       "required with `ramp`"});
  v.optional("apply", t.apply, any, {"event at which a setpoint takes effect"});
  v.optional("interpolate", t.interpolate, any, {"the drive ramps linearly to each setpoint within a cycle"});
  v.optional("enable_delay_ms", t.enable_delay, {.lo = 0.0, .hi = 10'000.0},
             {"time from Enable until a relay connects the output"});
  v.optional(
      "soft_start_ms", t.soft_start, {.lo = 0.0, .hi = 10'000.0},
      {"duration of the linear ramp to the setpoint after `enable_delay_ms`; the state is \"enabled\" after "
       "this ramp"});
}

/// Lists the keys of [axis.twin.sensor]. The keys noise_um_rms and resolution_um are in [axis.twin].
template <class V>
void visit_sensor(V& v, twin::AxisConfig& t) {
  twin::Sensor::Config& sensor = t.sensor;
  v.optional("bandwidth_Hz", sensor.bandwidth_Hz, not_negative,
             {"corner frequency of a first-order low pass for the position; 0: no low pass"});
  v.optional("noise_density_um_per_rtHz", sensor.noise_density_um_per_rtHz, not_negative,
             {"one-sided density of the white noise before the low pass"});
  v.optional("delay_us", sensor.delay, {.lo = 0.0, .hi = 100'000.0},
             {"a sample has the position that the stage had this time before the sampling"});
  v.optional("drift_um_per_h", sensor.drift_um_per_h, any, {"linear drift since the start of the twin"});
  v.optional("gain_error_percent", sensor.gain_error_percent, {.lo = -300.0, .hi = 300.0},
             {"gain error in percent of the position; -200: a reversed sensor"});
  v.optional("offset_um", sensor.offset_um, any, {"constant error"});
  v.optional("nonlinearity_percent", sensor.nonlinearity_percent, {.lo = -10.0, .hi = 10.0},
             {"nonlinearity in percent of the range"});
  v.optional("range_min_um", sensor.range_min_um, any,
             {"lowest position that the sensor reads", "unbounded"});
  v.optional("range_max_um", sensor.range_max_um, any,
             {"highest position that the sensor reads", "unbounded"});
  v.optional("sampling", t.sample_clock.sampling, any,
             {"the sensor samples at the SYNC (`sync`) or by its own clock (`free`)"});
  v.optional("sample_rate_Hz", t.sample_clock.rate_Hz, {.lo = 0.0, .hi = 10'000.0},
             {"rate of the sensor's own clock; 0: `rate_Hz`"});
  v.optional("skew_ppm", t.sample_clock.skew_ppm, {.lo = -10'000.0, .hi = 10'000.0},
             {"rate error of the sensor's own clock; above 0: the clock is fast"});
}

/// Lists the keys of [axis.twin.second_mode]. The functions below list the keys of [axis.twin.creep] and
/// [axis.twin.temperature].
template <class V>
void visit(V& v, twin::SecondMode& second) {
  v.required("resonance_Hz", second.mode.natural_frequency_Hz, positive, {"a second mechanical mode"});
  v.required("damping_ratio", second.mode.damping_ratio, not_negative, {"damping ratio of the second mode"});
  v.required("share", second.share, {.lo = 0.0, .hi = 1.0},
             {"share of this mode in the position; the first mode has the rest"});
}
template <class V>
void visit(V& v, twin::LogarithmicCreep& creep) {
  v.required("per_decade", creep.per_decade, {.lo = -0.1, .hi = 0.1},
             {"creep in each decade of time after a step, as a share of the step"});
  v.required("from_s", creep.from_s, positive,
             {"start of the interval in which creep is logarithmic in time"});
  v.required("to_s", creep.to_s, positive, {"end of the interval in which creep is logarithmic in time"});
}
template <class V>
void visit(V& v, twin::Temperature& temperature) {
  v.required("swing_K", temperature.swing_K, not_negative, {"amplitude of the ambient temperature"});
  v.required("period_s", temperature.period_s, positive, {"period of the ambient temperature"});
  v.required("expansion_um_per_K", temperature.expansion_um_per_K, any,
             {"change of the position per kelvin by thermal expansion"});
  v.required("gain_per_K", temperature.gain_per_K, any,
             {"relative change of the stroke per kelvin; its magnitude must be less than 1 / `swing_K`"});
}

/// Lists the keys of [axis.twin], which describe the simulated axis.
template <class V>
void visit_twin(V& v, AxisConfig& axis) {
  const std::string& unit = axis.wire.drive_unit;
  twin::AxisConfig& t = axis.twin;
  v.takes_effect(Effect::on_nodes);
  v.optional("model", axis.twin_model, any, {"model file of the twin, with any kind of model", "required"});
  v.optional("resonance_Hz", t.plant.mode.natural_frequency_Hz, positive,
             {"mechanical mode", "of the model"});
  v.optional("damping_ratio", t.plant.mode.damping_ratio, not_negative,
             {"damping ratio of the mode", "of the model"});
  v.required("drive_min_" + unit, t.plant.amplifier.drive_min, any, {"lowest output of the amplifier"});
  v.required("drive_max_" + unit, t.plant.amplifier.drive_max, any,
             {"highest output of the amplifier, at least `input_max` of the model (its upper threshold)"});
  v.required("safe_drive_" + unit, t.plant.amplifier.safe_drive, any,
             {"output of the amplifier if it is not enabled"});
  v.required("slew_" + unit + "_per_s", t.plant.amplifier.slew_per_s, positive, {"slew limit"});
  v.optional("bandwidth_Hz", t.plant.amplifier.bandwidth_Hz, positive, {"first-order lag", "of the model"});
  v.required("command_timeout_ms", t.command_timeout, positive,
             {"time without a command after which the amplifier's watchdog trips"});
  v.optional("status_every", t.status_every, {.lo = 1, .hi = 1000}, {"period of `AmpStatus` in SYNCs"});
  v.required("noise_um_rms", t.sensor.noise_um_rms, not_negative,
             {"standard deviation of the noise in one sample"});
  v.required("resolution_um", t.sensor.resolution_um, not_negative,
             {"size of the least significant bit; 0: not quantised"});
  v.optional("substep_us", t.plant.substep, {.lo = 1.0, .hi = 1000.0}, {"integration step"});
  visit_amplifier(v, unit, t);
  v.section("sensor", t, [](V& sub, twin::AxisConfig& value) { visit_sensor(sub, value); });
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.optional_table("second_mode", t.plant.second_mode, plain);
  v.optional_table("creep", t.plant.creep, plain);
  v.optional_table("temperature", t.plant.temperature, plain);
  v.optional_list("coupling", t.couplings, plain);
}

/// Lists the keys of [[twin.fault]]. They depend on the kind of fault.
template <class V>
void visit(V& v, twin::FaultSpec& f) {
  v.required("kind", f.kind, any,
             {"`no_reply`, `late`, `wrong_crc`, `node_reboot`, `load_step`, ...: [all kinds](../twin.md)"});
  v.alternative([&] { f = twin::fault_spec(f.kind, f.axis); });
  const twin::FaultTraits& its = twin::traits(f.kind);
  v.required("axis", f.axis, any, {"name of an axis"});
  if (its.site != twin::FaultSite::plant)
    v.optional(
        "node", f.node, any,
        {"node that has the fault; not for kinds of faults that affect the stage", "depends on the kind"});
  v.required("at_s", f.begins, not_negative, {"start of the fault, since the start of the twin"});
  v.required("duration_s", f.lasts, positive, {"duration of the fault"});
  if (!its.unit.empty())
    v.optional("value", f.value, {.lo = its.lowest, .hi = its.highest},
               {"number that some kinds of faults have, such as the cycles of `late`: "
                "[its meaning](../twin.md#faults)",
                "of the kind"});
  v.optional("repeat_every_s", f.repeat_every, not_negative,
             {"period of a repeated fault, more than `duration_s`; 0: the fault occurs once"});
}

/// Lists the keys of [twin.random_faults].
template <class V>
void visit(V& v, twin::RandomFaults& r) {
  v.optional("seed", r.seed, any, {"the same seed gives the same faults"});
  v.required("rate_per_hour", r.rate_per_hour, {.lo = 0.0, .hi = 36'000.0, .lo_excluded = true},
             {"mean number of faults per hour, of all kinds together"});
  v.optional("duration_min_s", r.shortest, positive,
             {"shortest duration of a fault; the durations are uniformly distributed"});
  v.optional("duration_max_s", r.longest, positive, {"longest duration of a fault"});
  v.optional("kinds", r.kinds, any,
             {"names of kinds of faults, for example `[\"late\", \"load_step\"]`", "all"});
}

template <class V>
void visit(V& v, twin::CommonConfig& t) {
  v.takes_effect(Effect::on_nodes);
  v.optional("seed", t.seed, any, {"seed of the noise of all sensors and amplifiers"});
  v.required("heartbeat_ms", t.heartbeat_period, positive, {"heartbeat period of the nodes"});
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.optional_list("fault", t.faults, plain);
  v.optional_table("random_faults", t.random_faults, plain);
}

}  // namespace hystcan::config
