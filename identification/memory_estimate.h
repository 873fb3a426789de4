// Estimates the memory of an actuator at the beginning of a dataset, with a model of the actuator.
#pragma once

#include <cstddef>

#include "identification/dataset.h"
#include "identification/initial_memory.h"
#include "identification/prediction.h"

namespace hystcan::identification {

struct MemoryEstimate {
  InitialMemory memory;
  double offset = 0.0;  ///< to be added to the model's output
  double rms = 0.0;     ///< error over the samples of the estimate, output units
};

/// Returns the memory and the offset with the smallest RMS error over the first `samples` samples. Without `with_offset`, the offset is 0.
MemoryEstimate estimate_memory(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                               std::size_t samples, bool with_offset);

}  // namespace hystcan::identification
