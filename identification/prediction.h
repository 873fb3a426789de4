// A model's prediction for a dataset, sample by sample.
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "identification/initial_memory.h"
#include "model/hysteresis.h"

namespace hystcan::identification {

struct ErrorNorms {
  double rms = 0.0;
  double max = 0.0;  ///< largest |error|

  /// Errors over the samples from `begin` on. Both vectors have the same length.
  static ErrorNorms of(const std::vector<double>& predicted, const std::vector<double>& measured,
                       std::size_t begin = 0);
};

/// max - min.
double span_of(const std::vector<double>& values);

/// Output at each sample of `dataset`. The input is delayed, and its turning points are kept (excerpt.h).
/// `state` is the memory at the first input, and afterwards the memory at the last one.
std::vector<double> predict(const model::Hysteresis& model, const Dataset& dataset, double delay_s,
                            model::HysteresisState& state);
std::vector<double> predict(const model::Hysteresis& model, const Dataset& dataset, double delay_s,
                            const InitialMemory& memory);

}  // namespace hystcan::identification
