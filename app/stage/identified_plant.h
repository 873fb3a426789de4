// Identifies the dynamics (the plant) of an axis from a record of small steps or a chirp.
//
// First, a mode behind a pure delay is fitted, for held drives (identification/dynamics/second_order_fit.h).
// The control loop needs a more exact chain: the amplifier and the sensor have lags, and the amplifier may
// interpolate. The mode is therefore fitted a second time, in this chain (app/stage/chain_record.h). If the
// amplitude of the mode shows that a part of the delay is not a lag, this part becomes a pure delay of the
// sensor.
//
// A record may show no mode. It may also show a wrong mode, because a mode above half the rate appears in the
// samples at another frequency. If such a mode explains the record no better than the stated mode, the record
// determines only delay and lag. The stated mode is then used, and the true frequency may be the stated one
// or any higher one.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "controller/analysis/loop_design.h"
#include "identification/dataset.h"
#include "identification/dynamics/second_order_fit.h"

namespace hystcan::app {

/// Relative standard error of a resonance that the user states: 19 of 20 stated values differ from the true
/// resonance by at most 10 %.
inline constexpr double stated_mode_error = 0.05;

struct IdentifiedPlant {
  /// Fitted mode with 95 % confidence intervals; `nullopt` if the record does not show a mode.
  std::optional<identification::SecondOrderFit> mode;
  std::string not_shown;  ///< reason why the record does not show a mode; empty if it does

  controller::Delays delays;  ///< identified amplifier, mode and sensor; the command delay is 0
  controller::PlantUncertainty uncertainty;
  identification::Estimate late_s;  ///< sum of lag and pure delay in s, without the delay that the user
                                    ///< stated for the sensor
  double pure_s = 0.0;              ///< pure delay of the sensor in s, a part of the total delay late_s
  double share_error = 0.0;         ///< standard error of the pure delay's share of the total delay
  /// Relative standard error of the resonance if the record does not show it; 0 if the record shows it.
  double mode_error = stated_mode_error;
  double gain = 0.0;          ///< output at rest for a drive of 1, in output units per drive unit
  double residual_rms = 0.0;  ///< RMS of the output that the plant does not explain, in output units
  double explained = 0.0;     ///< share of the output's variance that the plant explains, 0 to 1
  double cycle_s = 0.0;       ///< cycle time of the record
  std::size_t rows = 0;       ///< number of rows in the record
  std::size_t left_out = 0;   ///< number of cycles missing between the rows
};

/// Identifies the plant from the record. `stated`: mode and sensor as stated by the user, and whether the
/// amplifier interpolates. If the record shows a mode but no delay, the amplifier has the stated lag. Throws
/// std::invalid_argument if the plant cannot be identified from the record, or if the record contradicts the
/// stated delay of the sensor. Throws identification::OutputFalls if the output falls when the drive rises.
IdentifiedPlant identified_plant(const identification::Dataset& record, const controller::Delays& stated);

/// A damping ratio that the user states may be too large by at most this factor.
inline constexpr double stated_damping_factor = 1.5;

/// Returns true if the frequency of the mode `shown` agrees with the stated resonance within 15 %. If it does
/// not, `shown` may be a false image of the stated mode: a mode above half the rate appears in the samples at
/// another frequency.
bool is_as_stated(const identification::SecondOrderFit& shown, double stated_Hz);

}  // namespace hystcan::app
