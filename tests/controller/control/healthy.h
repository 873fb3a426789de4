// A driven axis for the supervisor: healthy nodes, samples, and limits for the checks.
#pragma once

#include <optional>

#include "controller/control/supervisor.h"

namespace hystcan::controller {

inline constexpr double exact_cycle_s = 1.0 / 1024.0;  // its sums are exact

inline constexpr NodeHealth all_is_well{.sensor_alive = true,
                                        .sensor_operational = true,
                                        .amplifier_alive = true,
                                        .amplifier_operational = true,
                                        .amplifier_ready = true,
                                        .amplifier_enabled = true};

/// The input of one exact cycle; `nullopt` if the sample is lost.
inline AxisInput sample(std::optional<double> position_um) {
  return {.time_s = 0.0,
          .dt_s = exact_cycle_s,
          .cycle_s = exact_cycle_s,
          .position_um = position_um,
          .health = all_is_well};
}

/// Limits only the position range and the lost samples; a test adds the limits that it examines.
inline Supervisor::Config basic_limits() {
  return {.position_min_um = -3.0,
          .position_max_um = 34.0,
          .position_jump_um = 0.0,
          .missing_samples = 3,
          .frozen_cycles = 0,
          .saturated_s = 0.0,
          .bus_passive_s = 0.0,
          .drive_range = 100.0};
}

/// Returns the first cycle, counted from 1, in which `step` returns a cause; 0: none in ten thousand cycles.
template <class Step>
int cycles_until_cause(Step step) {
  for (int cycle = 1; cycle <= 10'000; ++cycle)
    if (step(cycle) != Cause::none) return cycle;
  return 0;
}

}  // namespace hystcan::controller
