// The residuals of a model in the records from which it was identified, as a spectrum over the distance that
// the input travels. A reference that moves the input at u input units per second shows the octave at q as
// the frequency
//
//   f = q u
//
// If a record rings, its mode is in the spectrum at q = f / speed of the record.
#pragma once

#include <cstddef>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::identification {

struct Identified;

struct Misfit {
  double speed = 0.0;       ///< speed of the input, mean over the records, input units per second
  double lowest = 0.0;      ///< q at the start of the first octave, 1/input unit
  std::vector<double> rms;  ///< RMS of each octave, output units

  /// Returns the middle of an octave, 1/input unit.
  double middle(std::size_t octave) const;
};

/// Computes the spectrum of the residuals of all records under a Hann window, without the noise from sample
/// to sample. It is scaled to the held-out error (or to the error, if nothing was held out).
Misfit misfit_of(const Identified& identified, const std::vector<Dataset>& datasets);

}  // namespace hystcan::identification
