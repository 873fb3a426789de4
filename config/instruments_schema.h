// The keys of [axis.twin] for what amplifier and sensor are not perfect in. What they need of each other is
// checked in config/check_instruments.h.
#pragma once

#include <array>
#include <initializer_list>
#include <string>
#include <string_view>

#include "config/document.h"

namespace hystcan::config {

/// A choice by the name of one of `all`.
template <class V, class Choice, std::size_t n>
void visit_choice(V& v, std::string_view key, Choice& choice, const std::array<Choice, n>& all,
                  std::initializer_list<std::string_view> names) {
  std::string name(to_string(choice));
  v.optional_choice(key, name, names);
  for (const Choice one : all)
    if (to_string(one) == name) choice = one;
}

/// What the load makes of the amplifier: keys of a drive in volts, or in amperes.
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

/// What an amplifier has beside range, slew and bandwidth.
template <class V>
void visit_amplifier(V& v, const std::string& unit, twin::AxisConfig& t) {
  twin::Amplifier::Config& amplifier = t.plant.amplifier;
  visit_load(v, unit, amplifier);
  v.optional("drive_resolution_" + unit, amplifier.resolution, not_negative);
  v.optional("drive_noise_" + unit + "_per_rtHz", t.drive_noise.density_per_rtHz, not_negative);
  v.optional("ripple_" + unit, t.drive_noise.ripple, not_negative);
  v.optional("ripple_Hz", t.drive_noise.ripple_Hz, not_negative);
  visit_choice(v, "watchdog_action", t.watchdog_action, twin::all_watchdog_actions,
               {"safe", "hold", "ramp", "off"});
  v.limit("watchdog_ramp_" + unit + "_per_s", amplifier.ramp_per_s);
  visit_choice(v, "apply", t.apply, twin::all_apply, {"sync", "receipt"});
}

/// [axis.twin.sensor]: what a sensor has beside white noise and resolution.
template <class V>
void visit_sensor(V& v, twin::AxisConfig& t) {
  twin::Sensor::Config& sensor = t.sensor;
  v.optional("bandwidth_Hz", sensor.bandwidth_Hz, not_negative);
  v.optional("noise_density_um_per_rtHz", sensor.noise_density_um_per_rtHz, not_negative);
  v.optional("delay_us", sensor.delay, {.lo = 0.0, .hi = 100'000.0});
  v.optional("drift_um_per_h", sensor.drift_um_per_h);
  v.optional("gain_error_percent", sensor.gain_error_percent, {.lo = -50.0, .hi = 50.0});
  v.optional("offset_um", sensor.offset_um);
  v.optional("nonlinearity_percent", sensor.nonlinearity_percent, {.lo = -10.0, .hi = 10.0});
  v.bound("range_min_um", sensor.range_min_um);
  v.bound("range_max_um", sensor.range_max_um);
  visit_choice(v, "sampling", t.sample_clock.sampling, twin::all_samplings, {"sync", "free"});
  v.optional("sample_rate_Hz", t.sample_clock.rate_Hz, {.lo = 0.0, .hi = 10'000.0});
  v.optional("skew_ppm", t.sample_clock.skew_ppm, {.lo = -10'000.0, .hi = 10'000.0});
}

}  // namespace hystcan::config
