// The error of a prediction at different speeds of the input.
#pragma once

#include <cstddef>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::identification {

struct RateError {
  double speed = 0.0;  ///< mean of the half cycles of this class, input units per second
  double rms = 0.0;    ///< output units
  std::size_t samples = 0;
};

/// Half cycles are divided into classes a factor of two wide, slowest first. One class: all have about the same
/// speed.
std::vector<RateError> errors_by_rate(const Dataset& dataset, const std::vector<double>& predicted);

}  // namespace hystcan::identification
