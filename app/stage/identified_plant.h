// Identifies the plant of a loop from a record of small steps or a chirp.
//
// The fit of a mode (identification/dynamics/second_order_fit.h) assumes a mode behind a pure delay, and held
// drives. The chain of the loop has the lags of amplifier and sensor instead, and its amplifier may
// interpolate: its mode is therefore fitted again to the same record (app/stage/chain_record.h). If the
// amplitude of the mode shows that a part of the delay is not a lag, that part becomes a pure delay and is
// assigned to the sensor.
//
// The record may not show a mode, or it may show a different mode that explains the record no better than the
// stated one (a mode above half the rate appears in the samples at another frequency). Then the record
// determines only delay and lag. The stated mode is used, and the true frequency may be anything from there
// up.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "controller/analysis/loop_design.h"
#include "identification/dataset.h"
#include "identification/dynamics/second_order_fit.h"

namespace hystcan::app {

/// Relative standard error of a stated resonance: 19 of 20 stated values are within 10 % of the true value.
inline constexpr double stated_mode_error = 0.05;

struct IdentifiedPlant {
  /// Mode of the chain, with the intervals of the fit; `nullopt` if the record does not show a mode.
  std::optional<identification::SecondOrderFit> mode;
  std::string not_shown;  ///< reason why no mode is shown

  controller::Delays delays;  ///< the chain, without command delay
  controller::PlantUncertainty uncertainty;
  identification::Estimate
      late_s;                ///< sum of lag and delay, without the stated sensor, as if it were a pure delay
  double pure_s = 0.0;       ///< pure part of late_s, assigned to the sensor
  double share_error = 0.0;  ///< standard error of the pure share, 0 to 1
  /// Relative standard error of the resonance if the record does not show it; 0 if the record shows it.
  double mode_error = stated_mode_error;
  double gain = 0.0;          ///< output units per drive unit
  double residual_rms = 0.0;  ///< output units
  double explained = 0.0;     ///< share of the output's variance around a straight line, 0 to 1
  double cycle_s = 0.0;       ///< cycle of the record
  std::size_t rows = 0;       ///< rows of the record
  std::size_t left_out = 0;   ///< missing cycles between the rows
};

/// Identifies the plant from the record. `stated` contains the mode, the sensor, and whether the amplifier
/// interpolates. If the lag cannot be distinguished from zero, the plant has the lag of `stated`. Throws
/// std::invalid_argument if the record determines nothing, identification::OutputFalls if the gain is
/// negative.
IdentifiedPlant identified_plant(const identification::Dataset& record, const controller::Delays& stated);

/// Largest factor by which a stated damping ratio may be too large.
inline constexpr double stated_damping_factor = 1.5;

/// Returns true if the mode `shown` is within the accuracy of a stated resonance. Otherwise `shown` may be
/// the image of the stated mode: samples show a mode above half the rate at another frequency.
bool is_as_stated(const identification::SecondOrderFit& shown, double stated_Hz);

}  // namespace hystcan::app
