// Plants for tests: the piezo axis, and one with a known closed form.
#pragma once

#include <cmath>

#include "tests/support/piezo.h"
#include "twin/plant.h"

namespace hystcan::twin {

inline Plant::Config piezo_stage() {
  return {.hysteresis = support::piezo_model(),
          .mode = {.natural_frequency_Hz = 500.0, .damping_ratio = 0.05},
          .amplifier = {
              .drive_min = -20, .drive_max = 120, .slew_per_s = 93e3, .bandwidth_Hz = 1500, .safe_drive = 0}};
}

/// Without hysteresis: x_h = 0.3 um/V v, 0 to 100 V; the slew limit is never reached.
inline Plant::Config linear_stage() {
  Plant::Config config = piezo_stage();
  config.hysteresis = model::PrandtlIshlinskiiParameters{.input_unit = "V",
                                                         .output_unit = "um",
                                                         .input_range = {0.0, 100.0},
                                                         .offset = 0.0,
                                                         .gain = 0.3,
                                                         .thresholds = {},
                                                         .weights = {}};
  config.amplifier.slew_per_s = 1e9;
  return config;
}

/// A time after the start of virtual time, to the nanosecond.
inline can::Time at_s(double time_s) {
  return can::Time{} + can::Duration{static_cast<can::Duration::rep>(std::llround(1e9 * time_s))};
}

}  // namespace hystcan::twin
