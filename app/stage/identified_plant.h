// The plant of a loop from a record of small steps or a chirp.
//
// The fit of a mode (identification/dynamics/second_order_fit.h) knows a mode behind a pure delay and held
// drives. The chain of the loop has the lags of amplifier and sensor instead, and its amplifier may
// interpolate: its mode is found again in the same record (app/stage/chain_record.h). Where its amplitude
// shows that a part of the delay is no lag, that part is a pure delay, and counts as the sensor's.
//
// Where the record does not show a mode, or shows another one than the stated one, which explains it as well
// (samples show a mode above half the rate as another one), delay and lag are all that it determines. The
// mode is then the stated one, which may be anything from there up.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "controller/analysis/loop_design.h"
#include "identification/dataset.h"
#include "identification/dynamics/second_order_fit.h"

namespace hystcan::app {

/// Standard error of a stated resonance, as a share of it: 19 of 20 are within 10 %.
inline constexpr double stated_mode_error = 0.05;

struct IdentifiedPlant {
  /// That of the chain, with the intervals of the fit; empty: not shown.
  std::optional<identification::SecondOrderFit> mode;
  std::string not_shown;  ///< why

  controller::Delays delays;  ///< the chain, without command delay
  controller::PlantUncertainty uncertainty;
  identification::Estimate
      late_s;                ///< beside the stated sensor, if it were a pure delay: lag and delay together
  double pure_s = 0.0;       ///< of it, counted as the sensor's
  double share_error = 0.0;  ///< standard error of that share, 0 to 1
  /// Standard error of a resonance that is not shown, as a share of it; 0: it is shown.
  double mode_error = stated_mode_error;
  double gain = 0.0;          ///< output units per drive unit
  double residual_rms = 0.0;  ///< output units
  double explained = 0.0;     ///< share of the output's variance around a straight line, 0 to 1
  double cycle_s = 0.0;       ///< of the record
  std::size_t rows = 0;       ///< of the record
  std::size_t left_out = 0;   ///< cycles between them that have no row
};

/// `stated` has the mode, the sensor, and whether the amplifier interpolates. The lag stays that of `stated`
/// where it cannot be distinguished from zero. Throws std::invalid_argument where the record determines
/// nothing, identification::OutputFalls where the gain is negative.
IdentifiedPlant identified_plant(const identification::Dataset& record, const controller::Delays& stated);

/// A stated damping ratio is that much too large at most.
inline constexpr double stated_damping_factor = 1.5;

/// True: the mode is within what a stated resonance is good for. Another one may be its image in the samples.
bool is_as_stated(const identification::SecondOrderFit& shown, double stated_Hz);

}  // namespace hystcan::app
