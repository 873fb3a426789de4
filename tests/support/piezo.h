// A piezo axis for tests: small, self-contained, similar to the shipped one.
#pragma once

#include <limits>

#include "controller/control/axis.h"
#include "model/hysteresis.h"

namespace hystcan::support {

/// The stroke is 30 um at 100 V; the loop is 15 % of the stroke wide.
inline model::HysteresisParameters piezo_model() {
  const model::Interval range{0.0, 100.0};
  return {.input_unit = "V",
          .output_unit = "um",
          .ascending = {model::Basis::power, {0.0, 0.222, 0.00102, -2.4e-06}, range},
          .descending = {model::Basis::power, {1.5, 0.357, -0.00048, -2.4e-06}, range},
          .k_ascending = 0.035,
          .k_descending = 0.035};
}

/// A stage of 30 um at 100 V. Its lower threshold is exactly 0 um, so that sums of few terms are exact there.
inline model::HysteresisParameters model_from_zero() {
  const model::Interval range{0.0, 100.0};
  return {.input_unit = "V",
          .output_unit = "um",
          .ascending = {model::Basis::chebyshev, {14.0, 15.5, 0.5}, range},
          .descending = {model::Basis::chebyshev, {15.5, 15.0, -0.5}, range},
          .k_ascending = 0.035,
          .k_descending = 0.035};
}

inline controller::AxisConfig piezo_axis() {
  controller::AxisConfig config;
  config.law = {.structure = controller::Structure::inverse_pi,
                .model = piezo_model(),
                .pi = {.kp = 0.05, .ki_per_s = 120.0}};
  config.gate = {.drive_min = 0.0, .drive_max = 100.0, .slew_per_s = 20'000.0, .safe_drive = 0.0};
  config.delays = {
      .command_delay = std::chrono::milliseconds(1), .resonance_Hz = 500.0, .damping_ratio = 0.05};
  config.setpoint = {{.shape = controller::Hold{.level_um = 15.0, .duration_s = 1.0}, .transition_s = 0.05}};
  config.wipe_slew_per_s = 1000.0;
  config.wipe_dwell_s = 0.01;
  config.supervision.position_min_um = -3.0;
  config.supervision.position_max_um = 34.0;
  config.following_error.error_um = 2.0;
  config.following_error.cycles = 3;
  config.supervision.position_jump_um = 3.0;
  config.supervision.missing_samples = 3;
  config.supervision.bus_passive_s = 0.0095;
  return config;
}

/// The piezo axis in open loop.
inline controller::AxisConfig excited_piezo(const controller::Excitation::Config& excitation) {
  controller::AxisConfig config = piezo_axis();
  config.excitation = excitation;
  return config;
}

}  // namespace hystcan::support
