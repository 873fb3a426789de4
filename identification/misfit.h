// What a model leaves of the records that it was identified from, as a spectrum over the distance that the
// input travels: a reference that moves the input at u input units per second meets the octave at q as
//
//   f = q u
//
// A record that rings has its mode in it, at q = f / speed of the record.
#pragma once

#include <cstddef>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::identification {

struct Identified;

struct Misfit {
  double speed = 0.0;       ///< of the input, mean over the records, input units per second
  double lowest = 0.0;      ///< q at which the first octave begins, 1/input unit
  std::vector<double> rms;  ///< of each octave, output units

  /// The middle of an octave, 1/input unit.
  double middle(std::size_t octave) const;
};

/// The residuals of all records under a Hann window, as large as the error of what was held out (without it:
/// the error), without the noise from sample to sample.
Misfit misfit_of(const Identified& identified, const std::vector<Dataset>& datasets);

}  // namespace hystcan::identification
