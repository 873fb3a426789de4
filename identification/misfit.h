// Computes the spectrum of a model's residuals (measured output minus predicted output), as one RMS value per
// octave. The spectrum is over the distance that the input travels, and not over time. Its variable is
// therefore a spatial frequency q: periods of the residual per input unit of distance. If the input moves
// with the speed u, the model error at q oscillates in time with the frequency
//
//   f = q u        u in input units per second, f in Hz
//
// If the second-order mode of the stage rings with the frequency f in a record, the spectrum contains this
// ringing at q = f / (mean speed of the input in the record).
#pragma once

#include <cstddef>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::identification {

struct Identified;

struct Misfit {
  double speed = 0.0;       ///< mean speed of the input in all records, input units per second
  double lowest = 0.0;      ///< lower end of the first octave, periods per input unit
  std::vector<double> rms;  ///< RMS of the residual in each octave, output units

  /// Returns the middle of an octave, periods per input unit. The first octave has the number 0.
  double middle(std::size_t octave) const;
};

/// Computes the spectrum of the residuals of all records under a Hann window. The noise of single samples is
/// subtracted. The sum over all octaves is scaled to the held-out error, or to the error of the fit if
/// nothing was held out.
Misfit misfit_of(const Identified& identified, const std::vector<Dataset>& datasets);

}  // namespace hystcan::identification
