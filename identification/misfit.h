// The residuals of a model in its records, as a spectrum over the distance that the input travels (and not
// over time). The spectrum has one value per octave. A residual at q, in periods per input unit, appears at
// the frequency f if a reference moves the input with the speed u:
//
//   f = q u        u in input units per second
//
// If the mode of the stage rings in a record, the spectrum contains it at q = f / speed of the record.
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
