// What a model says of a record, sample by sample.
#pragma once

#include <vector>

#include "identification/initial_memory.h"
#include "identification/record.h"
#include "model/hysteresis.h"

namespace hystcan::identification {

struct Misses {
  double rms = 0.0;
  double max = 0.0;  ///< largest |error|

  /// Over the samples from `begin` on. Of equal length.
  static Misses of(const std::vector<double>& predicted, const std::vector<double>& measured,
                   std::size_t begin = 0);
};

/// max - min.
double span_of(const std::vector<double>& values);

/// Output at each sample of `record`: the input delayed, its turning points kept (excerpt.h).
/// `state`: the memory at the first input; at the end, the memory at the last one.
std::vector<double> predict(const model::Hysteresis& model, const Record& record, double delay_s,
                            model::HysteresisState& state);
std::vector<double> predict(const model::Hysteresis& model, const Record& record, double delay_s,
                            const InitialMemory& memory);

}  // namespace hystcan::identification
